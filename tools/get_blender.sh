#!/usr/bin/env bash
# get_blender.sh
# Prints the path of a Blender for Linux x64, fetched once and kept outside the checkout: the official build,
# or where that cannot be had, on Debian, the distribution's newest Blender with all it needs, a virtual display and
# software GL for its window too. That is unpacked beside the system, whose packages and sources stay as they are, and
# runs in a mount namespace of its own.
set -euo pipefail
version=${BLENDER_VERSION:-5.2.3}
name=blender-$version-linux-x64 suite=sid
cache=${XDG_CACHE_HOME:-$HOME/.cache}/multibounce-ao
home=$cache/debian-$suite-window
[ "$(uname -sm)" = "Linux x86_64" ] || { echo "install Blender and set BLENDER=/path/to/blender" >&2; exit 1; }
mkdir -p "$cache"
exec 9>"$cache/.lock"; flock 9   # two runs at once: the second waits and finds the first one's

works() { "$1" -b --factory-startup --version >/dev/null 2>&1; }

official() {
  local url="https://download.blender.org/release/Blender${version%.*}"
  command -v curl >/dev/null || return 1
  local part; part=$(mktemp -d "$cache/part.XXXXXX")
  if (cd "$part" &&
      curl -fsSL --connect-timeout 10 -O "$url/blender-$version.sha256" -O "$url/$name.tar.xz" &&
      sha256sum --quiet --ignore-missing -c "blender-$version.sha256" && tar -xf "$name.tar.xz") >&2; then
    rm -rf "${cache:?}/$name"; mv "$part/$name" "$cache/"
  fi
  rm -rf "$part"
}

debian() {
  command -v apt-get >/dev/null && command -v unshare >/dev/null || return 1
  echo "fetching $suite's Blender instead (about 400 MB)" >&2
  local apt=$home/apt root=$home/root
  rm -rf "$home"
  mkdir -p "$apt"/{lists/partial,cache/archives/partial,state,parts} "$root"/usr/{bin,sbin,lib,lib64}
  : > "$apt/status"
  local mirror
  mirror=$(cat /etc/apt/sources.list.d/debian.sources /etc/apt/sources.list 2>/dev/null |
    sed -n 's/^URIs:[[:space:]]*//p; s/^deb \(\[[^]]*\] \)\?\([^ ]*\) .*/\2/p' | head -1)
  local key=/usr/share/keyrings/debian-archive-keyring.gpg
  echo "deb [signed-by=$key] $mirror $suite main" > "$apt/sources.list"
  cat > "$apt/apt.conf" <<X
Dir::Etc { SourceList "$apt/sources.list"; SourceParts "-"; };
Dir::Etc { Preferences "/dev/null"; PreferencesParts "$apt/parts"; };
Dir::State "$apt/state"; Dir::State::Lists "$apt/lists"; Dir::State::Status "$apt/status";
Dir::Cache "$apt/cache"; Dir::Cache::Archives "$apt/cache/archives";
APT::Install-Recommends "false"; APT::Sandbox::User "root";
Acquire::Languages "none"; Acquire::Retries "5";
X
  export APT_CONFIG=$apt/apt.conf
  apt-get -qq update >&2 || return 1
  apt-get -qq install -y --download-only blender python3-numpy python3-cattr python3-requests \
    python3-zstandard dash coreutils xvfb x11-xkb-utils xkb-data libgl1 libegl1 libglx-mesa0 libegl-mesa0 \
    libgl1-mesa-dri >/dev/null || return 1

  # Unpacked only: no package's script runs, so what those would have linked is linked here.
  local dir deb lib=$root/usr/lib/x86_64-linux-gnu
  for dir in bin sbin lib lib64; do ln -s "usr/$dir" "$root/$dir"; done
  for deb in "$apt"/cache/archives/*.deb; do
    dpkg-deb --fsys-tarfile "$deb" | tar -x -C "$root" --keep-directory-symlink --no-same-owner \
      --exclude='./usr/share/doc' --exclude='./usr/share/man' --exclude='./usr/share/locale'
  done
  [ -e "$lib/libblas.so.3" ] || ln -s blas/libblas.so.3 "$lib/libblas.so.3"
  [ -e "$lib/liblapack.so.3" ] || ln -s lapack/liblapack.so.3 "$lib/liblapack.so.3"
  [ -e "$root/usr/bin/sh" ] || ln -s dash "$root/usr/bin/sh"
  mkdir -p "$root"/{proc,sys,dev,tmp,run,etc,var/tmp}
  ln -s /proc/self/mounts "$root/etc/mtab"
  cp /etc/passwd /etc/group /etc/hosts "$root/etc/"
  rm -rf "$apt"

  cat > "$home/blender" <<'X'
#!/usr/bin/env bash
# Runs this folder's Blender. The host's folders, but for those of its system, are the same ones inside.
export LANG=C.UTF-8 LC_ALL=C.UTF-8 PATH=/usr/bin:/bin
unset PYTHONHOME PYTHONPATH VIRTUAL_ENV LD_LIBRARY_PATH
as=-m; [ "$(id -u)" = 0 ] || as=-Urm
root=$(dirname "$(readlink -f "$0")")/root
exec unshare $as --propagation private -- /bin/bash -c '
  root=$1; shift
  for dir in /*; do
    case $dir in /usr|/bin|/sbin|/lib*|/etc|/var|/boot|/lost+found) continue;; esac
    [ -d "$dir" ] && mkdir -p "$root$dir" 2>/dev/null && mount --rbind "$dir" "$root$dir" || continue
  done
  exec unshare --root="$root" --wd="$PWD" -- /usr/bin/blender "$@"' in "$root" "$@"
X
  chmod +x "$home/blender"
}

for attempt in : official debian; do
  $attempt || true
  for blender in "$cache/$name/blender" "$home/blender"; do
    if works "$blender"; then echo "$blender"; exit 0; fi
  done
done
[ ! -e "$home/blender" ] || "$home/blender" -b --version >&2 || true   # says what is wrong with it
echo "no Blender could be fetched: install one and set BLENDER=/path/to/blender" >&2
exit 1
