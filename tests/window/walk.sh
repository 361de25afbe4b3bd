#!/usr/bin/env bash
# Uses the real window on a virtual display, with mouse and keyboard, from start to export. Saves the pictures of README and guide.
# Call: tests/window/walk.sh [PROGRAM]   (default: builds and runs target/release/loopscope)
# Needs: xvfb xdotool imagemagick libgl1 libxcursor1 libxi6 libxkbcommon-x11-0
set -euo pipefail
cd "$(dirname "$0")/../.."

for tool in Xvfb xdotool import convert; do
  command -v "$tool" >/dev/null || { echo "walk: $tool is missing; nothing was tried" >&2; exit 77; }
done
program=${1:-}
if [ -z "$program" ]; then
  cargo build --release
  program=target/release/loopscope
fi
program=$(realpath "$program")
assets=$(realpath assets)

folder=$(mktemp -d)
display=":$((90 + RANDOM % 100))"
Xvfb "$display" -screen 0 1280x800x24 >/dev/null 2>&1 &
server=$!
end() {
  kill "$window_process" "$server" 2>/dev/null || true
  wait 2>/dev/null || true
  rm -rf "$folder"
}
window_process=$server
trap end EXIT
export DISPLAY="$display" LIBGL_ALWAYS_SOFTWARE=1 XDG_DATA_HOME="$folder/data"

fail() { echo "walk: $1" >&2; import -window root "${TMPDIR:-/tmp}/walk-failed.png" || true; exit 1; }

# Waits until a command succeeds, at most ten seconds.
until_holds() {
  for _ in $(seq 100); do
    if eval "$1" >/dev/null 2>&1; then return; fi
    sleep 0.1
  done
  fail "never true: $1"
}

click() { xdotool mousemove "$1" "$2" sleep 0.15 click 1 sleep 0.4; }
key() { xdotool key "$@" sleep 0.4; }
picture() { sleep "${2:-1}"; import -window root -strip "$assets/$1.png"; }

until_holds "xdotool getmouselocation"
cd "$folder"
started=$(date +%s%N)
"$program" 2>"$folder/errors" &
window_process=$!
until_holds "xdotool search --name LoopScope"
id=$(xdotool search --name LoopScope | tail -1)
echo "the window was there after $(( ($(date +%s%N) - started) / 1000000 )) ms"
sleep 0.5
xdotool windowsize "$id" 1280 800 windowmove "$id" 0 0
until_holds "xdotool windowfocus $id"
sleep 3 # the built-in sensor is simulated and fitted

# At this position, the pointer shows the past sample.
xdotool mousemove 640 370
picture window 4

# F2 to F8 show the workspaces; Ctrl+1 to 9 bring a pane to the front.
key F5
xdotool mousemove 200 450
picture thresholds 6
key F4
picture loops 3
key F3

# Exports the calibration through the palette and a typed path, because file dialogs need a desktop.
key ctrl+p
xdotool type --delay 20 "export cal"
key Return
sleep 1
key ctrl+a
xdotool type --delay 20 "$folder/walked.json"
key Return
until_holds "grep -q compensated '$folder/walked.json'"

# A session with only the built-in sensor closes without a question.
key ctrl+q
until_holds "! kill -0 $window_process"
# Without a desktop, the crate of the file dialogs (rfd) prints that it has none.
if grep -v "rfd::" "$folder/errors"; then fail "something was written to standard error"; fi

# The first tutorial of the guide: a file without a header, the errors, the check of the recordings, and the export.
"$program" demo recordings >/dev/null
mkdir own
days=(monday tuesday wednesday thursday friday)
for day in 1 2 3 4 5; do
  cp "recordings/train_path${day}_mount${day}_medium.csv" "own/${days[day - 1]}.csv"
done
cp recordings/test_path6_mount4_fast.csv own/test.csv
tail -n +2 own/friday.csv >own/bare.csv
# Saves a picture for the guide, with few colours so that the file is small.
small() { sleep "$2"; import -window root "$folder/whole.png"; convert "$folder/whole.png" -strip +dither -colors 32 "png8:$assets/guide/$1.png"; }
open() {
  "$program" "$@" 2>"$folder/errors" &
  window_process=$!
  until_holds "xdotool search --name LoopScope"
  id=$(xdotool search --name LoopScope | tail -1)
  sleep 1
  xdotool windowsize "$id" 1280 800 windowmove "$id" 0 0
  until_holds "xdotool windowfocus $id"
  xdotool mousemove 200 360
  sleep 2
}
find_action() {
  key ctrl+p
  sleep 1
  xdotool type --delay 40 "$1"
  sleep 1
  key Return
  sleep 1
}
open own/bare.csv
small first-import 2
kill "$window_process"
until_holds "! kill -0 $window_process"
rm -rf "$XDG_DATA_HOME" # otherwise the next window would offer to restore the unsaved session
open own/{monday,tuesday,wednesday,thursday,friday,test}.csv
small first-errors 2
key F7
small first-enough 4
find_action "export cal"
key ctrl+a
xdotool type --delay 20 "$folder/own.json"
key Return
until_holds "grep -q compensated '$folder/own.json'"
kill "$window_process"
until_holds "! kill -0 $window_process"

"$program" fit --json >/dev/null || fail "the command line does not work beside it"
echo "walked: pictures are in assets/"
