#!/bin/sh
# Runs a compiler through ccache. If an old precompiled header exists, the preprocessor reads it instead of the headers from which it was
# made. Then ccache would not notice changes of these headers. Therefore this script first removes the precompiled header that the compiler
# is going to write.
previous=
for word in "$@"; do
  case "$previous $word" in "-o "*.gch) rm -f "$word" ;; esac
  previous=$word
done
# With the first two settings, a clone in one folder can use what was compiled in another folder. The ccache manual requires the third
# setting for precompiled headers ("Precompiled headers").
CCACHE_BASEDIR=${0%/cmake/compile.sh} CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=pch_defines,time_macros exec ccache "$@"
