// Copies of files that nobody can change.
#pragma once

#include <string>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// Copies a file into memory, and seals the memory: from then on no process can change the copy, not even
/// this one. So what is checked in the copy is also what is loaded or executed from it later. In
/// /proc/PID/maps, the copy is named `/memfd:` and the name of the file.
Result<Fd> sealed_copy(const std::string& path);
/// The same for an open file, which is called `path` in the name of the copy and in errors. Fails if `from`
/// is empty: the file was sent to this process when it had too many open files.
Result<Fd> sealed_copy(const Fd& from, const std::string& path);

/// Returns a path under which every process of this user can open the file, as long as this process keeps it
/// open. A debugger can use this path, too, but not a path in /proc/self/fd.
std::string path_of(const Fd& file);

}  // namespace takt::os
