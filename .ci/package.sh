#!/usr/bin/env bash
# Packs a program that is built:  .ci/package.sh [PROGRAM [FOLDER]]
# (default: target/release/loopscope, target/package). On Linux a .deb and a .tar.gz.
# On macOS the program may hold both processors (lipo): an app in a .dmg, and the .tar.gz. On Windows (Git's bash) a .zip.
# The same program gives the same bytes on Linux. SHA256SUMS lists what is there.
set -euo pipefail
cd "$(dirname "$0")/.."

program=$(realpath "${1:-target/release/loopscope}")
out=${2:-target/package}
said=$("$program" --version | tr -d '\r')
version=$(sed -n 's/^loopscope //p' <<<"$said")
target=${TARGET:-$(sed -n 's/^target: //p' <<<"$said")}
export SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || date +%s)}
umask 022
mkdir -p "$out"
out=$(realpath "$out")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# What every archive holds: the program, what it does and under which terms.
name=loopscope-$version-$target
folder=$work/$name
mkdir -p "$folder"
cp LICENSE-MIT LICENSE-APACHE README.md CHANGELOG.md "$folder"
cp assets/licences.txt "$folder/LICENCES-OF-CRATES.txt"

case $target in
*-windows-*)
  cp "$program" "$folder/loopscope.exe"
  rm -f "$out/$name.zip"
  (cd "$work" && 7z a -bso0 "$out/$name.zip" "$name")
  ;;
*)
  cp "$program" "$folder/loopscope"
  "$program" man "$folder/man"
  mkdir "$folder/completions"
  "$program" completions bash >"$folder/completions/loopscope.bash"
  "$program" completions zsh >"$folder/completions/_loopscope"
  "$program" completions fish >"$folder/completions/loopscope.fish"
  ;;
esac

case $target in
*-linux-*)
  mkdir "$folder/desktop"
  cp assets/loopscope.{desktop,svg,png} assets/loopscope-mime.xml assets/io.github.loopscope.loopscope.metainfo.xml "$folder/desktop"
  same_bytes=(--sort=name --owner=0 --group=0 --numeric-owner --mtime="@$SOURCE_DATE_EPOCH")
  tar -C "$work" "${same_bytes[@]}" -c "$name" | gzip -9n >"$out/$name.tar.gz"

  case $target in
  x86_64-*) architecture=amd64 ;;
  aarch64-*) architecture=arm64 ;;
  *) echo "package: no Debian name is known for $target" >&2; exit 1 ;;
  esac
  root=$work/deb
  share=$root/usr/share
  install -Dm755 "$folder/loopscope" "$root/usr/bin/loopscope"
  install -Dm644 assets/loopscope.desktop "$share/applications/loopscope.desktop"
  install -Dm644 assets/loopscope.png "$share/icons/hicolor/256x256/apps/loopscope.png"
  install -Dm644 assets/loopscope.svg "$share/icons/hicolor/scalable/apps/loopscope.svg"
  install -Dm644 assets/loopscope-mime.xml "$share/mime/packages/loopscope.xml"
  install -Dm644 assets/io.github.loopscope.loopscope.metainfo.xml -t "$share/metainfo"
  install -Dm644 "$folder/completions/loopscope.bash" "$share/bash-completion/completions/loopscope"
  install -Dm644 "$folder/completions/_loopscope" "$share/zsh/vendor-completions/_loopscope"
  install -Dm644 "$folder/completions/loopscope.fish" "$share/fish/vendor_completions.d/loopscope.fish"
  install -Dm644 "$folder"/man/*.1 -t "$share/man/man1"
  install -Dm644 LICENSE-MIT "$share/doc/loopscope/copyright"
  cat LICENSE-APACHE assets/licences.txt >>"$share/doc/loopscope/copyright"
  install -Dm644 CHANGELOG.md "$share/doc/loopscope/NEWS"
  gzip -9n "$share"/man/man1/*.1 "$share/doc/loopscope/NEWS"
  # The window's libraries are found at run time, so no tool lists them; without a window none of them is asked for.
  libc=$(objdump -T "$program" | grep -o 'GLIBC_[0-9.]*' | sort -Vu | tail -1)
  mkdir "$root/DEBIAN"
  cat >"$root/DEBIAN/control" <<END
Package: loopscope
Version: $version
Architecture: $architecture
Maintainer: LoopScope
Installed-Size: $(du -ks "$root/usr" | cut -f1)
Depends: libc6 (>= ${libc#GLIBC_}), libgcc-s1, libegl1, libgl1, libwayland-client0, libwayland-egl1, libx11-6, libx11-xcb1, libxcb1, libxcursor1, libxi6, libxkbcommon-x11-0, libxkbcommon0, libxrender1
Recommends: libdbus-1-3, libfontconfig1, xdg-desktop-portal | zenity
Section: science
Priority: optional
Description: calibrate force/torque sensors, with what their past does to them
 Reads recordings of raw gauges and of the applied load, fits a calibration
 whenever a slider moves, and shows errors and hysteresis loops before and
 after compensation. Exports matrices, and code that a robot runs. With a
 command line for all of it.
END
  (cd "$root" && find usr -type f | LC_ALL=C sort | xargs md5sum >DEBIAN/md5sums)
  dpkg-deb --root-owner-group -Zxz --build "$root" "$out/loopscope_${version}_$architecture.deb" >/dev/null
  ;;
*-apple-*)
  tar -C "$work" -czf "$out/$name.tar.gz" "$name"
  app=$work/dmg/LoopScope.app/Contents
  mkdir -p "$app/MacOS" "$app/Resources" "$work/loopscope.iconset"
  cp "$program" "$app/MacOS/loopscope"
  cp LICENSE-MIT LICENSE-APACHE assets/licences.txt "$app/Resources"
  for size in 16 32 128 256; do
    sips -z $size $size assets/loopscope.png --out "$work/loopscope.iconset/icon_${size}x$size.png" >/dev/null
  done
  iconutil -c icns "$work/loopscope.iconset" -o "$app/Resources/loopscope.icns"
  sed "s/@VERSION@/$version/" assets/Info.plist >"$app/Info.plist"
  plutil -lint "$app/Info.plist" >/dev/null
  codesign --force --sign - "$work/dmg/LoopScope.app" # without a developer's identity: the system asks before the first start
  ln -s /Applications "$work/dmg/Applications"
  hdiutil create -quiet -ov -volname LoopScope -srcfolder "$work/dmg" -format UDZO "$out/$name.dmg"
  ;;
esac

cd "$out"
sha256() { if command -v sha256sum >/dev/null; then sha256sum "$@"; else shasum -a 256 "$@"; fi; }
packed=()
for file in *.deb *.tar.gz *.zip *.dmg; do
  if [ -e "$file" ]; then packed+=("$file"); fi
done
sha256 "${packed[@]}" >SHA256SUMS
ls -l "${packed[@]}"
