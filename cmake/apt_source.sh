#!/bin/sh
# Downloads the upstream archive of a source package and prints its path.
#     apt_source.sh PACKAGE FOLDER
# The package lists are the machine's own, with deb turned into deb-src; lists and state live in FOLDER, so that nothing
# of the system is touched and no privilege is needed.
set -eu
package=$1
mkdir -p "$2/sources.list.d" "$2/lists/partial" "$2/cache/archives/partial"
folder=$(cd "$2" && pwd)

for file in /etc/apt/sources.list /etc/apt/sources.list.d/*; do
  [ -f "$file" ] || continue
  copy=$folder/sources.list.d/$(basename "$file")
  case $file in
    *.sources) sed 's/^Types:.*/Types: deb-src/' "$file" > "$copy" ;;
    *.list) sed -n 's/^[[:space:]]*deb[[:space:]]/deb-src /p' "$file" > "$copy" ;;
  esac
done

apt() {
  apt-get -q -o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts="$folder/sources.list.d" \
    -o Dir::State::lists="$folder/lists" -o Dir::Cache="$folder/cache" -o APT::Sandbox::User=root \
    -o Acquire::Retries=2 -o Acquire::http::Timeout=30 "$@" >&2
}
apt update
cd "$folder"
apt source --download-only --tar-only "$package"
ls "$folder/${package}"_*.orig.tar.* | grep -v '\.asc$' | head -1
