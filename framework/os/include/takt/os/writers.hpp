// Checks who can replace a file.
#pragma once

#include <string>

#include <takt/core/result.hpp>

namespace takt::os {

/// Fails if a user without Takt's rights can replace the file or folder at `path`. Such a user owns a folder
/// or link on the way from the root folder to `path`, or the file itself, or may write to one of them. Takt
/// trusts root, its own user, the owners of its program file and of the folders above it, and, if Takt runs
/// as root, the user who called sudo. A group that has only one member counts as this member. In a folder
/// with the sticky bit, such as /tmp, users cannot replace the files of others. Also fails if an access
/// control list lets anybody write, or if `path` does not exist and other users may create it.
///
/// After a success, only the users whom Takt trusts can change what `path` refers to.
Result<void> check_writers(const std::string& path);

}  // namespace takt::os
