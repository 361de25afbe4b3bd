#!/usr/bin/env bash
# Installs a .deb in a Debian that holds nothing else, and starts it there:  .ci/package-test.sh FILE.deb FILE.tar.gz [PICTURE.png]
# As root. Needs: mmdebstrap debian-archive-keyring, and for the window xvfb xdotool imagemagick; shared-mime-info and libglib2.0-bin for the MIME types.
set -euo pipefail
cd "$(dirname "$0")/.."

deb=$(realpath "$1")
archive=$(realpath "$2")
picture=$(realpath -m "${3:-${TMPDIR:-/tmp}/package-test.png}")
root=$(mktemp -d)
server=
window=
end() {
  [ -z "$window" ] || kill "$window" 2>/dev/null || true
  [ -z "$server" ] || kill "$server" 2>/dev/null || true
  wait 2>/dev/null || true
  umount "$root/proc" 2>/dev/null || true
  rm -rf --one-file-system "$root"
}
trap end EXIT
fail() { echo "package-test: $1" >&2; exit 1; }
inside() { chroot "$root" /usr/bin/env -i HOME=/root LANG=C.UTF-8 LIBGL_ALWAYS_SOFTWARE=1 PATH=/usr/sbin:/usr/bin:/sbin:/bin "$@"; }

# The archive holds the program in a folder of its name.
case $(tar -tzf "$archive") in *"$(basename "$archive" .tar.gz)/loopscope"*) ;; *) fail "there is no program in $archive" ;; esac

mmdebstrap --quiet --variant=minbase --keyring=/usr/share/keyrings/debian-archive-keyring.gpg bookworm "$root" http://deb.debian.org/debian
mount -t proc proc "$root/proc"
cp "$deb" "$root/tmp/loopscope.deb"
inside apt-get update -qq
inside sh -c 'DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends /tmp/loopscope.deb' >"$root/installed" 2>&1 \
  || { cat "$root/installed"; fail "it cannot be installed"; }
inside loopscope --version
inside sh -c 'cd /root && loopscope demo recordings --pattern b >/dev/null \
  && loopscope fit --train recordings/train_*.csv --test recordings/test_*.csv --export sensor.json --export sensor.h >/dev/null' 2>/dev/null
[ -s "$root/root/sensor.h" ] || fail "nothing was exported"
for path in applications/loopscope.desktop icons/hicolor/256x256/apps/loopscope.png mime/packages/loopscope.xml; do
  [ -s "$root/usr/share/$path" ] || fail "$path is not installed"
done
# A minimal Debian leaves manual pages out, so they are looked for in the package itself.
case $(dpkg-deb -c "$deb") in *man1/loopscope-fit.1.gz*) ;; *) fail "there is no manual page" ;; esac

# What a session, a calibration, a factory's .cal and a file of somebody else are taken for.
if command -v gio >/dev/null && command -v update-mime-database >/dev/null; then
  cp -r "$root/usr/share/mime" "$root/home/mime"
  cp /usr/share/mime/packages/freedesktop.org.xml "$root/home/mime/packages"
  update-mime-database "$root/home/mime" 2>/dev/null
  is() {
    local found
    found=$(XDG_DATA_HOME="$root/home" XDG_DATA_DIRS="$root/none" gio info -a standard::content-type "$root/root/$1" | sed -n 's/.*content-type: //p')
    [ "$found" = "$2" ] || fail "$1 is taken for $found"
  }
  printf '{\n  "format": "loopscope session",\n  "version": 1\n}\n' >"$root/root/session.json"
  printf '{\n  "format": "others"\n}\n' >"$root/root/other.json"
  printf '<?xml version="1.0" encoding="utf-8"?>\n<FTSensor/>\n' >"$root/root/factory.cal"
  is session.json application/x-loopscope-session+json
  is sensor.json application/x-loopscope-calibration+json
  is other.json application/json
  is factory.cal application/x-ft-sensor-calibration+xml
else
  echo "package-test: no gio or no shared-mime-info; MIME types were not tried" >&2
fi

# The window, on a display outside: none of its libraries comes with a server.
if command -v Xvfb >/dev/null && command -v import >/dev/null; then
  display=":$((300 + RANDOM % 100))"
  Xvfb "$display" -screen 0 1280x800x24 >/dev/null 2>&1 &
  server=$!
  sleep 1
  printf '{"format": "loopscope session", "version": 1, "built_in": true, "notes": "opened by its path"}' >"$root/root/session.json"
  inside DISPLAY="$display" loopscope /root/session.json 2>"$root/errors" &
  window=$!
  for _ in $(seq 100); do
    if DISPLAY="$display" xdotool search --name "session.*LoopScope|LoopScope.*session" >/dev/null 2>&1; then break; fi
    kill -0 "$window" 2>/dev/null || { cat "$root/errors"; fail "the window did not open"; }
    sleep 0.2
  done
  sleep 5
  kill -0 "$window" 2>/dev/null || { cat "$root/errors"; fail "the window closed by itself"; }
  DISPLAY="$display" xdotool search --name session >/dev/null || fail "the session was not opened"
  DISPLAY="$display" import -window root -strip "$picture"
  [ "$(convert "$picture" -unique-colors -format %w info:)" -gt 100 ] || fail "the window is empty; see $picture"
  echo "package-test: the window is in $picture"
else
  echo "package-test: no Xvfb; the window was not tried" >&2
fi

inside apt-get remove -qq -y loopscope >/dev/null 2>&1
if [ -e "$root/usr/bin/loopscope" ] || [ -e "$root/usr/share/doc/loopscope" ]; then fail "something stays when it is removed"; fi
echo "package-test: installed, started and removed"
