#!/usr/bin/env bash
# make_venv.sh PYTHON VENV
# Makes the virtual environment VENV with PYTHON (3.11 or 3.13), and in it tools/requirements.txt.
# What Debian keeps in packages of its own is installed with apt-get where that is allowed, else named.
set -euo pipefail
python=$1 venv=$2
cd "$(dirname "$0")/.."
# Shared libraries that every desktop has and the bpy module is linked to.
bpy_packages="libx11-6 libxfixes3 libxi6 libxrender1 libxxf86vm1 libxkbcommon0 libsm6 libice6 libgl1 libgomp1"

need() {   # need WHAT PACKAGE...
  local what=$1 as=""; shift
  local install="apt-get install -y --no-install-recommends $*"
  [ "$(id -u)" = 0 ] || as="sudo -n"
  if command -v apt-get >/dev/null && $as true 2>/dev/null; then
    echo "$what: installing $*"
    $as apt-get -qq update
    DEBIAN_FRONTEND=noninteractive $as $install >/dev/null && return
  fi
  echo "$what. On Debian or Ubuntu run:  sudo $install" >&2
  exit 1
}

version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null) || version=missing
case $version in
  3.11|3.13) ;;
  *) echo "Python 3.11 (for Blender 4.5) or 3.13 (for 5.2) is needed, $python is $version:" \
       "name one, for instance  make test PYTHON=python3.13" >&2
     exit 1;;
esac

"$python" -c 'import ensurepip, venv' 2>/dev/null ||
  need "Python's venv is not installed" "python$version-venv"
"$python" -m venv --clear "$venv"
echo "installing tools/requirements.txt into $venv"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r tools/requirements.txt

"$venv/bin/python" -c 'import bpy' 2>/dev/null ||
  need "The bpy module needs shared libraries" $bpy_packages
"$venv/bin/python" -c 'import bpy'
