//! The codes of a Deflate block (RFC 1951, sections 3.2.2 and 3.2.7), and its bits.

/// The longest code of a literal, a length or a distance.
pub(super) const LONGEST: u8 = 15;
/// The longest code of a code's length.
const LONGEST_OF_LENGTHS: u8 = 7;
/// The order in which the lengths of codes of lengths stand.
const ORDER: [usize; 19] = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];

/// A prefix code for symbols from 0 on.
pub(super) struct Code {
    /// Bits of each symbol's word; 0 where it does not occur.
    lengths: Vec<u8>,
    /// Each symbol's word, the first bit lowest.
    words: Vec<u16>,
}

impl Code {
    /// The shortest code for symbols that occur as often as `counts` says, with words of at most `longest` bits.
    pub(super) fn of(counts: &[u32], longest: u8) -> Self {
        let mut counts = counts.to_vec();
        // A code of one word is not whole.
        let lacking = 2_usize.saturating_sub(counts.iter().filter(|count| **count > 0).count());
        counts.iter_mut().filter(|count| **count == 0).take(lacking).for_each(|count| *count = 1);
        loop {
            let lengths = lengths(&counts);
            if lengths.iter().all(|length| *length <= longest) {
                return Self { words: words(&lengths), lengths };
            }
            // Evener counts have evener words.
            counts.iter_mut().filter(|count| **count > 0).for_each(|count| *count = *count / 2 + 1);
        }
    }

    /// A symbol's word and its bits.
    #[inline]
    pub(super) fn word(&self, symbol: usize) -> (u64, u32) {
        (u64::from(self.words[symbol]), u32::from(self.lengths[symbol]))
    }
}

/// Huffman's lengths (1952), by the two queues of leaves and of joined nodes.
fn lengths(counts: &[u32]) -> Vec<u8> {
    let mut leaves: Vec<(u32, usize)> = counts.iter().copied().zip(0..).filter(|leaf| leaf.0 > 0).collect();
    leaves.sort_unstable();
    let mut weights: Vec<u32> = leaves.iter().map(|leaf| leaf.0).collect();
    let mut parents = vec![0; 2 * leaves.len() - 1];
    let (mut leaf, mut joined) = (0, leaves.len());
    for node in leaves.len()..parents.len() {
        let mut weight = 0;
        for _ in 0..2 {
            let is_leaf = leaf < leaves.len() && (joined == node || weights[leaf] <= weights[joined]);
            let next = if is_leaf { &mut leaf } else { &mut joined };
            weight += weights[*next];
            parents[*next] = node;
            *next += 1;
        }
        weights.push(weight);
    }
    let mut depths = vec![0_u8; parents.len()];
    for node in (0..parents.len() - 1).rev() {
        depths[node] = depths[parents[node]] + 1;
    }
    let mut lengths = vec![0; counts.len()];
    leaves.iter().zip(depths).for_each(|(leaf, depth)| lengths[leaf.1] = depth);
    lengths
}

/// The canonical words of codes of these lengths.
fn words(lengths: &[u8]) -> Vec<u16> {
    let mut next = [0_u16; LONGEST as usize + 1];
    let mut word = 0;
    for length in 1..=LONGEST {
        next[usize::from(length)] = word;
        let count = lengths.iter().filter(|other| **other == length).count() as u16;
        word = (word + count) << 1;
    }
    let word = |length: &u8| match length {
        0 => 0,
        length => {
            let next = &mut next[usize::from(*length)];
            *next += 1;
            (*next - 1).reverse_bits() >> (16 - length)
        }
    };
    lengths.iter().map(word).collect()
}

/// Bits on their way into bytes, the first lowest.
pub(super) struct Bits {
    bytes: Vec<u8>,
    waiting: u64,
    count: u32,
}

impl Bits {
    pub(super) fn with_capacity(bytes: usize) -> Self {
        Self { bytes: Vec::with_capacity(bytes), waiting: 0, count: 0 }
    }

    /// Puts the lowest `count` bits of `value`, which has no others; 32 at most.
    #[inline]
    pub(super) fn put(&mut self, (value, count): (u64, u32)) {
        self.waiting |= value << self.count;
        self.count += count;
        if self.count >= 32 {
            self.bytes.extend_from_slice(&(self.waiting as u32).to_le_bytes());
            self.waiting >>= 32;
            self.count -= 32;
        }
    }

    /// Begins a block, not the last, with these codes for literals with lengths, and for distances.
    pub(super) fn begin_block(&mut self, literals: &Code, distances: &Code) {
        const DYNAMIC: (u64, u32) = (0b100, 3);
        self.put(DYNAMIC);
        self.put((literals.lengths.len() as u64 - 257, 5));
        self.put((distances.lengths.len() as u64 - 1, 5));
        let lengths = [literals.lengths.as_slice(), &distances.lengths].concat();
        let steps = steps(&lengths);
        let mut counts = [0; ORDER.len()];
        steps.iter().for_each(|step| counts[step.0] += 1);
        let code = Code::of(&counts, LONGEST_OF_LENGTHS);
        self.put((ORDER.len() as u64 - 4, 4));
        ORDER.iter().for_each(|length| self.put((u64::from(code.lengths[*length]), 3)));
        for (symbol, more) in steps {
            self.put(code.word(symbol));
            self.put(more);
        }
    }

    /// Fills the last byte by an empty block, and gives the bytes.
    pub(super) fn finish(mut self) -> Vec<u8> {
        const STORED: (u64, u32) = (0, 3);
        const EMPTY: [u8; 4] = [0, 0, 0xff, 0xff];
        self.put(STORED);
        let bytes = self.count.div_ceil(8) as usize;
        self.bytes.extend_from_slice(&self.waiting.to_le_bytes()[..bytes]);
        self.bytes.extend(EMPTY);
        self.bytes
    }
}

/// How lengths of codes are told: symbols, each with bits behind it. Only zeros are counted.
fn steps(lengths: &[u8]) -> Vec<(usize, (u64, u32))> {
    let mut steps = Vec::new();
    for same in lengths.chunk_by(|one, other| *one == 0 && *other == 0) {
        if same[0] > 0 {
            steps.push((usize::from(same[0]), (0, 0)));
            continue;
        }
        for zeros in same.chunks(138) {
            match zeros.len() as u64 {
                few @ ..3 => (0..few).for_each(|_| steps.push((0, (0, 0)))),
                some @ ..11 => steps.push((17, (some - 3, 3))),
                many => steps.push((18, (many - 11, 7))),
            }
        }
    }
    steps
}
