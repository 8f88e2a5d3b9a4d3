#!/bin/sh
# fastddsgen4.sh FASTDDSGEN SCRATCH OUT FILE.idl ...: runs fastddsgen 4, which belongs to Fast DDS 3. Its files get the names and the plain
# enumerations that fastddsgen 2 gives them, so that one source can include either.
set -eu
generator=$1
scratch=$2
out=$3
shift 3
mkdir -p "$scratch/out"
"$generator" -replace -cs -de final -no-typeobjectsupport -t "$scratch" -d "$scratch/out" "$@"
for idl; do
  stem=${idl%.idl}
  echo "#include \"${stem}CdrAux.ipp\"" >"$out/$stem.cxx"
  for part in .hpp CdrAux.hpp CdrAux.ipp PubSubTypes.hpp PubSubTypes.cxx; do
    name=$stem$part
    sed -E '/^#include ".*CdrAux\.ipp"/d; s/^( *)enum class (\w+) : int32_t/\1enum \2 : uint32_t/; s/^(#include "\w+)\.hpp"/\1.h"/' "$scratch/out/$name" \
      >"$out/$(echo "$name" | sed 's/\.hpp$/.h/')"
  done
done
