//! LAZ: the compressed records of a LAS file.
//!
//! What the file tells of its compression is looked at before the crate `laz` is: it takes memory for as many chunks and
//! as long layers as it is told of, and stops in a panic at items that do not belong together.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use las::raw::Header;
use laz::laszip::{ChunkTable, ChunkTableEntry, LazItemType};
use laz::{
    DecompressionSelection, LasZipDecompressor, LazItemRecordBuilder, LazVlr, par_decompress_selective,
};
use rayon::prelude::*;

use super::Records;
use super::caught::caught;
use crate::object::model::error::{ModelError, Place};
use crate::object::model::open;

/// Bytes of the head of a variable length record.
const RECORD_HEAD: u64 = 54;
/// The most variable length records that are looked through.
const MOST_RECORDS: u32 = 100_000;

/// The most bytes of a chunk, compressed or not, for several to be decompressed at once.
const LARGEST_CHUNK: u64 = 64 << 20;

/// The number of the oldest way to compress.
const WITHOUT_CHUNKS: Option<u8> = Some(1);

/// Points that are decompressed by one task of the thread pool, in whole chunks: at least so many where there are more.
const POINTS_A_TASK: u64 = 50_000;

/// Hands the points of the file at `path` of `length` bytes to `take`, in blocks from any thread, the first block first.
pub(super) fn read(
    path: &Path,
    header: &Header,
    records: &Records,
    length: u64,
    take: impl Fn(&[u8]) + Sync,
) -> Result<(), ModelError> {
    let mut reader = BufReader::new(open(path)?.0);
    let unreadable = |source| ModelError::Unreadable { path: path.to_owned(), source };
    let start = u64::from(header.offset_to_point_data);
    let fail = |at: u64, what: &str| Err(ModelError::damaged(path, Place::Byte(at), what));
    let Some((at, description)) = description(&mut reader, header, start).map_err(unreadable)? else {
        return fail(u64::from(header.header_size), "no record tells how the points are compressed");
    };
    let way = description.first().copied();
    let Ok(description) = LazVlr::from_buffer(&description) else {
        return fail(at, "the record that tells how the points are compressed is damaged");
    };
    if !is_of_format(&description, records) {
        return fail(at, "the points are compressed as another format than the header tells");
    }
    if !chunks_are_few(&mut reader, start, length).map_err(unreadable)? {
        return fail(start, "the table of chunks lies beyond the file, or tells of more than it can hold");
    }
    let layers: u64 = description.items().iter().map(|item| layers_of(item.item_type())).sum();
    if layers > 0 {
        check_layers(&mut reader, records, layers, start, length)
            .map_err(|at| ModelError::damaged(path, Place::Byte(at), "a chunk is longer than the file"))?;
    }
    reader.seek(SeekFrom::Start(start)).map_err(unreadable)?;
    let wanted = DecompressionSelection(DecompressionSelection::Z | DecompressionSelection::RGB);
    let table = match way {
        WITHOUT_CHUNKS => None,
        _ => ChunkTable::read_from(&mut reader, &description).ok(),
    };
    if let Some(table) = table.filter(|table| is_sound(table, records, length)) {
        let chunks =
            Chunks { path, start: start + 8, description: &description, wanted, bytes: records.bytes };
        return chunks.read(&table, records.count, take);
    }
    reader.seek(SeekFrom::Start(start)).map_err(unreadable)?;
    let mut points = caught(|| LasZipDecompressor::selective(reader, description, wanted))
        .map_err(|what| ModelError::damaged(path, Place::Byte(start), what))?;
    records.blocks(path, |block| caught(|| Ok(points.decompress_many(block)?)), take)
}

/// Chunks that a table tells of, none of which is large: several are decompressed at once.
struct Chunks<'a> {
    path: &'a Path,
    /// Where the first begins.
    start: u64,
    description: &'a LazVlr,
    wanted: DecompressionSelection,
    /// Bytes of a record.
    bytes: usize,
}

/// Chunks that follow each other.
struct Task {
    /// Where the first begins, and the number of its first point.
    at: u64,
    first: u64,
    chunks: Vec<ChunkTableEntry>,
}

impl Chunks<'_> {
    fn read(&self, table: &ChunkTable, count: u64, take: impl Fn(&[u8]) + Sync) -> Result<(), ModelError> {
        let tasks = self.tasks(table, count);
        let Some((first, rest)) = tasks.split_first() else { return Ok(()) };
        self.decompress(first, &mut Default::default(), &take)?;
        let failed = rest
            .par_iter()
            .map_init(Default::default, |buffers, task| self.decompress(task, buffers, &take))
            .find_map_first(Result::err);
        failed.map_or(Ok(()), Err)
    }

    /// The chunks of `count` points.
    fn tasks(&self, table: &ChunkTable, count: u64) -> Vec<Task> {
        let mut tasks: Vec<Task> = Vec::new();
        let (mut at, mut done) = (self.start, 0);
        for chunk in table.as_ref() {
            // The last one's number of points is not always told.
            let points = chunk.point_count.min(count - done);
            if points == 0 {
                break;
            }
            let chunk = ChunkTableEntry { point_count: points, ..*chunk };
            match tasks.last_mut().filter(|task| done - task.first < POINTS_A_TASK) {
                Some(task) => task.chunks.push(chunk),
                None => tasks.push(Task { at, first: done, chunks: vec![chunk] }),
            }
            at += chunk.byte_count;
            done += points;
        }
        tasks
    }

    fn decompress(
        &self,
        task: &Task,
        (compressed, block): &mut (Vec<u8>, Vec<u8>),
        take: &impl Fn(&[u8]),
    ) -> Result<(), ModelError> {
        let sum = |of: fn(&ChunkTableEntry) -> u64| task.chunks.iter().map(of).sum::<u64>() as usize;
        compressed.resize(sum(|chunk| chunk.byte_count), 0);
        block.resize(sum(|chunk| chunk.point_count) * self.bytes, 0);
        let damaged = |what: String| {
            let place = Place::Element(format!("one of the points from {} on", task.first + 1));
            ModelError::damaged(self.path, place, what)
        };
        let mut file = open(self.path)?.0;
        let read = file.seek(SeekFrom::Start(task.at)).and_then(|_| file.read_exact(compressed));
        read.map_err(|error| damaged(error.to_string()))?;
        let (mut from, mut to) = (compressed.as_slice(), block.as_mut_slice());
        for chunk in &task.chunks {
            let (own, rest) = from.split_at(chunk.byte_count as usize);
            let (points, other) = to.split_at_mut(chunk.point_count as usize * self.bytes);
            let chunk = std::slice::from_ref(chunk);
            let done = caught(|| par_decompress_selective(own, points, self.description, chunk, self.wanted));
            done.map_err(damaged)?;
            (from, to) = (rest, other);
        }
        take(block);
        Ok(())
    }
}

/// Where the record that tells of the compression is, and its bytes.
fn description(
    reader: &mut BufReader<File>,
    header: &Header,
    points: u64,
) -> std::io::Result<Option<(u64, Vec<u8>)>> {
    let mut at = u64::from(header.header_size);
    for _ in 0..header.number_of_variable_length_records.min(MOST_RECORDS) {
        reader.seek(SeekFrom::Start(at))?;
        let mut head = [0; RECORD_HEAD as usize];
        if at >= points || reader.read_exact(&mut head).is_err() {
            return Ok(None);
        }
        let (user, number) = (&head[2..18], u16::from_le_bytes([head[18], head[19]]));
        let length = u16::from_le_bytes([head[20], head[21]]);
        at += RECORD_HEAD;
        if user.starts_with(LazVlr::USER_ID.as_bytes()) && number == LazVlr::RECORD_ID {
            let mut bytes = vec![0; usize::from(length)];
            return Ok(reader.read_exact(&mut bytes).is_ok().then_some((at, bytes)));
        }
        at += u64::from(length);
    }
    Ok(None)
}

/// Whether the items that are compressed are those of the records' format.
fn is_of_format(description: &LazVlr, records: &Records) -> bool {
    let extra = records.bytes as u64 - u64::from(super::FORMATS[usize::from(records.format)].0);
    let Ok(extra) = u16::try_from(extra) else { return false };
    let Ok(wanted) = LazItemRecordBuilder::default_for_point_format_id(records.format, extra) else {
        return false;
    };
    let items = description.items();
    let versions_agree = items.iter().all(|item| (item.version() > 2) == (layers_of(item.item_type()) > 0));
    items.len() == wanted.len()
        && versions_agree
        && items
            .iter()
            .zip(&wanted)
            .all(|(item, wanted)| item.item_type() == wanted.item_type() && item.size() == wanted.size())
}

/// Whether the table of chunks is within the file and has no more chunks than fit into it, if there is a table.
fn chunks_are_few(reader: &mut BufReader<File>, start: u64, length: u64) -> std::io::Result<bool> {
    let mut number = [0; 8];
    reader.seek(SeekFrom::Start(start))?;
    if reader.read_exact(&mut number).is_err() {
        return Ok(false);
    }
    let mut table = i64::from_le_bytes(number);
    if table <= start as i64 {
        // The table's place then stands at the end.
        reader.seek(SeekFrom::End(-8))?;
        reader.read_exact(&mut number)?;
        table = i64::from_le_bytes(number);
    }
    let Some(table) = u64::try_from(table).ok().filter(|table| table.saturating_add(8) <= length) else {
        return Ok(false);
    };
    reader.seek(SeekFrom::Start(table))?;
    reader.read_exact(&mut number)?;
    let [_, _, _, _, count @ ..] = number;
    // Each chunk begins with a whole record, of 20 bytes at least.
    Ok(u64::from(u32::from_le_bytes(count)) <= length / 20)
}

/// Layers into which an item is compressed; none by the older, pointwise compression.
fn layers_of(item: LazItemType) -> u64 {
    match item {
        LazItemType::Point14 => 9,
        LazItemType::RGB14 | LazItemType::WavePacket14 => 1,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(bytes) => u64::from(bytes),
        _ => 0,
    }
}

/// Whether the table tells of all points, of no more bytes than the file has, and of no large chunk.
fn is_sound(table: &ChunkTable, records: &Records, length: u64) -> bool {
    let chunks = table.as_ref();
    let most = LARGEST_CHUNK / records.bytes as u64;
    let is_small = |chunk: &ChunkTableEntry| {
        chunk.byte_count <= LARGEST_CHUNK && (1..=most).contains(&chunk.point_count)
    };
    // Small chunks, of which there are less than 2^32, have sums that fit.
    chunks.iter().all(is_small)
        && chunks.iter().map(|chunk| chunk.byte_count).sum::<u64>() <= length
        && chunks.iter().map(|chunk| chunk.point_count).sum::<u64>() >= records.count
}

/// Holds the lengths of all chunks' layers against the file's; tells where one is too long.
fn check_layers(
    reader: &mut BufReader<File>,
    records: &Records,
    layers: u64,
    start: u64,
    length: u64,
) -> Result<(), u64> {
    let mut at = start + 8;
    let mut points = 0;
    while points < records.count {
        // A whole record, the number of points, and the lengths.
        let head_at = at + records.bytes as u64;
        let mut head = vec![0; 4 + 4 * layers as usize];
        if reader.seek(SeekFrom::Start(head_at)).is_err() || reader.read_exact(&mut head).is_err() {
            return Err(at);
        }
        let mut numbers = head.as_chunks().0.iter().map(|four| u64::from(u32::from_le_bytes(*four)));
        points += numbers.next().filter(|points| *points > 0).ok_or(at)?;
        let end = head_at + head.len() as u64 + numbers.sum::<u64>();
        if end > length {
            return Err(at);
        }
        at = end;
    }
    Ok(())
}
