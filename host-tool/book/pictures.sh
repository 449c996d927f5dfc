#!/usr/bin/env bash
# Makes the pictures of the artist's chapter by the commands that it tells:
#
#   cargo build --release -p vitrine && host-tool/book/pictures.sh target/release/vitrine
#
# It needs ImageMagick, poppler-utils, and what tests/browser/set-up.sh installs, and takes some minutes.
set -euo pipefail
vitrine=$(realpath "${1:?name the vitrine command}")
cd "$(dirname "$0")/../.."
root=$PWD
pictures=$root/host-tool/book/src/artist/pictures
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/photos"
cp host-tool/photos/*.jpg "$work/photos"
cd "$work"

row() { montage "${@:2}" -tile x1 -geometry 256x256+6+6 -background white -strip -quality 84 "$pictures/$1.jpg"; }

"$vitrine" new exhibit --from photos
row photos photos/*.jpg

"$vitrine" check exhibit/exhibit.toml --frontier frontier.svg
cp frontier.svg "$pictures"

"$vitrine" design exhibit/exhibit.toml -o build
row films build/films/film-{01,08,14,20}.png
node "$root/tests/browser/screenshot.mjs" build/report.html report.png
convert report.png -strip -quality 80 "$pictures/report.jpg"

"$vitrine" view build --view coffee --encode -o own.png
"$vitrine" view build --horizontal 0 --encode -o between.png
row views own.png between.png

"$vitrine" demo exhibit/exhibit.toml -o walk
convert walk/contact-sheet.png -resize 900x -strip -quality 80 "$pictures/walk.jpg"

"$vitrine" print build -o sheets --dpi 720 --format pdf
pdftoppm -r 50 -png -f 1 -l 1 sheets/assembly.pdf assembly
pdftoppm -r 50 -png -f 1 -l 1 sheets/sheet-01.pdf sheet
convert assembly*.png sheet*.png -resize x560 -bordercolor gray -border 1 +append -strip -quality 84 "$pictures/sheets.jpg"
