#!/usr/bin/env bash
# Draws contour lines that are longer than 10 on a hillshade, one pixel of the picture for each of the hillshade's:
#   draw_lines.sh HILLSHADE.tif LINES.gpkg PICTURE.png      Needs Debian's gdal-bin and python3-gdal.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT

printf 'nv 255 255 255\n1 1 1 1\n255 255 255 255\n' > "$folder/colours"
gdaldem color-relief -q "$1" "$folder/colours" "$folder/map.tif"
gdal_rasterize -q -sql 'SELECT geom FROM contours WHERE ST_Length(geom) > 10' -burn 200 -burn 60 -burn 10 -b 1 -b 2 -b 3 "$2" "$folder/map.tif"
rgb2pct.py -n 128 "$folder/map.tif" "$folder/few.tif" > /dev/null
gdal_translate -q -of PNG "$folder/few.tif" "$3"
rm -f "$3.aux.xml"
