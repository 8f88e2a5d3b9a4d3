#!/bin/sh
# Runs a compiler through ccache. If an old precompiled header exists, the preprocessor reads it instead of the headers from which it was
# made. Then ccache would not notice changes of these headers. Therefore this script first removes the precompiled header that the compiler
# is going to write.
previous=
for word in "$@"; do
  case "$previous $word" in "-o "*.gch) rm -f "$word" ;; esac
  previous=$word
done
# The ccache manual requires these settings for precompiled headers ("Precompiled headers").
CCACHE_SLOPPINESS=pch_defines,time_macros exec ccache "$@"
