#!/usr/bin/env bash
# Draws contour lines on a hillshade, index lines bold, one pixel of the picture for each of the hillshade's:
#   draw_lines.sh HILLSHADE.tif LINES.gpkg PICTURE.png      Needs Debian's gdal-bin and python3-gdal.
set -euo pipefail
[[ $# -eq 3 ]] || { echo "usage: scripts/draw_lines.sh HILLSHADE.tif LINES.gpkg PICTURE.png" >&2; exit 2; }
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT

printf 'nv 255 255 255\n1 1 1 1\n255 255 255 255\n' > "$folder/colours"
gdaldem color-relief -q "$1" "$folder/colours" "$folder/map.tif"
draw() { gdal_rasterize -q "$@" -burn 200 -burn 60 -burn 10 -b 1 -b 2 -b 3 "$folder/map.tif"; }
draw -sql 'SELECT geom FROM contours' "$2"
draw -at -sql 'SELECT ST_Buffer(geom, 0.2) FROM contours WHERE "index"' -dialect sqlite "$2"
rgb2pct.py -n 48 "$folder/map.tif" "$folder/few.tif" > /dev/null
gdal_translate -q -of PNG "$folder/few.tif" "$3"
rm -f "$3.aux.xml"
