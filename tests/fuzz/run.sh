#!/bin/sh
# Runs a fuzzer over its seeds.
#
#   run.sh FOLDER RUNS PROGRAM [ARGUMENTS]      FOLDER_seeds holds the seeds
#
# If the environment variable TAKT_FUZZ_SECONDS is set, the fuzzer looks for new inputs for so long and keeps them in FOLDER_corpus.
# Otherwise it tests RUNS inputs: the seeds, and those that it derives from them with a fixed random seed, so that a change of the code
# and not luck decides whether it finds a bug.
set -eu
folder=$1 runs=$2
shift 2
set -- "$@" -timeout=20 -rss_limit_mb=2048 "-artifact_prefix=${folder}_artifacts/"
if [ -n "${TAKT_FUZZ_SECONDS:-}" ]; then
  exec "$@" "-max_total_time=$TAKT_FUZZ_SECONDS" "${folder}_corpus" "${folder}_seeds"
fi
rm -rf "${folder}_short"
mkdir "${folder}_short"
exec "$@" -seed=1 "-runs=$runs" "${folder}_short" "${folder}_seeds"
