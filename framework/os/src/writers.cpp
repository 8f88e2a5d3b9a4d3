#include <takt/os/writers.hpp>

#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>

#include <takt/os/environment.hpp>
#include <takt/os/fd.hpp>
#include <takt/os/sealed_copy.hpp>
#include "error.hpp"

namespace takt::os {

namespace {

namespace fs = std::filesystem;

/// The number of links in a path that the kernel follows.
constexpr int kMostLinks = 40;
/// The memory for an entry of the user or group database, in bytes.
using Memory = std::array<char, 16384>;

/// Returns the owners of this program's file and of the folders above it. Takt trusts them, because they can
/// replace the program, and so could act as its user anyway.
std::set<uid_t> owners_of_program() {
  std::set<uid_t> owners;
  std::error_code error;
  for (fs::path part = fs::read_symlink("/proc/self/exe", error); !error && part.has_relative_path();
       part = part.parent_path()) {
    struct stat status {};
    if (::stat(part.c_str(), &status) == 0) owners.insert(status.st_uid);
  }
  return owners;
}

bool is_trusted(uid_t user) {
  if (user == 0 || user == ::geteuid()) return true;
  static const std::set<uid_t> owners = owners_of_program();
  return owners.contains(user) || (is_root() && environment("SUDO_UID") == std::to_string(user));
}

/// Returns the name of a group that has members whom Takt does not trust; nothing if there are none. Many
/// systems give each user a group with the user's name, to which no other user belongs.
std::optional<std::string> untrusted_group(gid_t id) {
  Memory memory{};
  group entry{};
  group* found = nullptr;
  if (::getgrgid_r(id, &entry, memory.data(), memory.size(), &found) != 0 || found == nullptr)
    return std::to_string(id);
  const std::string name = found->gr_name;
  for (char** member = found->gr_mem; *member != nullptr; ++member) {
    if (name != *member) return name;
  }
  passwd user{};
  passwd* owner = nullptr;
  Memory of_user{};
  if (::getpwnam_r(name.c_str(), &user, of_user.data(), of_user.size(), &owner) != 0 || owner == nullptr)
    return name;
  return is_trusted(owner->pw_uid) ? std::nullopt : std::optional{name};
}

/// Returns true if an access control list gives further users or groups access. The rights of the group in
/// the mode are then the most that any of them may do.
bool has_access_list(const Fd& entry) {
  return ::getxattr(path_of(entry).c_str(), "system.posix_acl_access", nullptr, 0) > 0;
}

/// Checks the owner and the access rights of one part of a path.
Result<void> check_part(const std::string& name, const Fd& entry, const struct stat& status) {
  if (!is_trusted(status.st_uid)) {
    const std::string owner = user_name(status.st_uid);
    const std::string ours = user_name(::geteuid());
    return fail(name + " belongs to user " + owner + ", who can replace it, but Takt runs as user " + ours,
                "run chown -h " + ours + " " + name + ", or run Takt as user " + owner);
  }
  if (S_ISLNK(status.st_mode)) return {};  // a link has no access rights of its own
  if (S_ISDIR(status.st_mode) && (status.st_mode & S_ISVTX) != 0) return {};
  const auto rights = [&status] {
    std::array<char, 8> mode{};
    std::snprintf(mode.data(), mode.size(), "%04o", status.st_mode & 07777U);
    return " (owner " + user_name(status.st_uid) + ", mode " + mode.data() + ")";
  };
  if ((status.st_mode & S_IWOTH) != 0)
    return fail("everybody may write to " + name + rights(), "run chmod o-w " + name);
  if ((status.st_mode & S_IWGRP) == 0) return {};
  if (has_access_list(entry))
    return fail("an access control list lets other users write to " + name + rights(),
                "run setfacl -b " + name);
  if (const auto group = untrusted_group(status.st_gid))
    return fail("group " + *group + " may write to " + name + rights(), "run chmod g-w " + name);
  return {};
}

/// Returns true if other users may create files in a folder that passes check_part().
bool others_may_create(const struct stat& folder) {
  return (folder.st_mode & S_IWOTH) != 0 ||
         ((folder.st_mode & S_IWGRP) != 0 && untrusted_group(folder.st_gid));
}

/// The parts of a path that are still to be opened.
class Rest {
 public:
  explicit Rest(const fs::path& path) { put_first(path); }
  void put_first(const fs::path& path) {
    const fs::path relative = path.relative_path();
    parts_.insert(parts_.begin(), relative.begin(), relative.end());
  }
  std::optional<std::string> next() {
    if (parts_.empty()) return std::nullopt;
    std::string part = std::move(parts_.front());
    parts_.pop_front();
    return part;
  }

 private:
  std::deque<std::string> parts_;
};

}  // namespace

Result<void> check_writers(const std::string& path) {
  std::error_code error;
  Rest rest{fs::absolute(path, error)};
  if (error) return error_problem("the current folder", error.value());
  // Opens one part after the other, each in the folder that was checked before, so that nobody can exchange a
  // part between its check and its use.
  const auto root = [] { return Fd{::open("/", O_PATH | O_CLOEXEC)}; };
  Fd folder = root();
  fs::path place = "/";
  struct stat status {};
  if (!folder || ::fstat(folder.get(), &status) != 0) return errno_problem(path);
  if (auto checked = check_part("/", folder, status); !checked) return checked;
  const struct stat of_root = status;
  struct stat of_folder = status;
  int links = 0;
  while (const auto part = rest.next()) {
    if (part->empty() || *part == ".") continue;
    const fs::path here = *part == ".." ? place.parent_path() : place / *part;
    Fd entry{::openat(folder.get(), part->c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC)};
    if (!entry && errno == ENOENT && others_may_create(of_folder)) {
      return fail(here.string() + " does not exist, and other users may create it",
                  "create it first, or name another folder");
    }
    // This part does not exist, or Takt may not enter it. Only trusted users can change this, so the check
    // succeeds.
    if (!entry && (errno == ENOENT || errno == ENOTDIR || errno == EACCES)) return {};
    if (!entry || ::fstat(entry.get(), &status) != 0) return errno_problem(path);
    if (auto checked = check_part(here.string(), entry, status); !checked) return checked;
    if (!S_ISLNK(status.st_mode)) {
      folder = std::move(entry);
      of_folder = status;
      place = here;
      continue;
    }
    std::array<char, PATH_MAX> text{};
    const ssize_t length = ::readlinkat(entry.get(), "", text.data(), text.size());
    if (length < 0) return errno_problem(path);
    if (++links > kMostLinks) return error_problem(path, ELOOP, "remove the circular link " + here.string());
    const fs::path target = std::string{text.data(), static_cast<std::size_t>(length)};
    rest.put_first(target);
    if (!target.is_absolute()) continue;
    folder = root();
    if (!folder) return errno_problem(path);
    of_folder = of_root;
    place = "/";
  }
  return {};
}

}  // namespace takt::os
