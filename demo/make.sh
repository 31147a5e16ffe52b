#!/bin/sh
# Makes part.gcode again from the model script and the slicer settings. Needs python3 and PrusaSlicer 2.5.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 "$here/ribbon_vase.py" "$work/ribbon-vase.stl"
cd "$work"
prusa-slicer --load "$here/slicer.ini" --center 100,100 --export-gcode ribbon-vase.stl --output part.gcode >slicer.log || {
    cat slicer.log >&2
    exit 1
}
# The slicer's first line carries the date, its last block repeats slicer.ini: neither says anything about the part.
{
    echo "; Ribbon vase, 20 mm: demo/ribbon_vase.py sliced with demo/slicer.ini (docs/demo.md)"
    sed -e '1d' -e '/^; prusaslicer_config = begin/,/^; prusaslicer_config = end/d' part.gcode
} >"$here/part.gcode"
