#include <takt/os/files.hpp>

#include <elf.h>
#include <fcntl.h>
#include <link.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <takt/os/fd.hpp>
#include <takt/os/writers.hpp>
#include "error.hpp"

namespace takt::os {

bool is_executable(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode) && ::access(path.c_str(), X_OK) == 0;
}

bool is_shared_object(const std::string& path) {
  std::ifstream file{path, std::ios::binary};
  ElfW(Ehdr) header{};
  if (!file.read(reinterpret_cast<char*>(&header), sizeof header)) return false;
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 || header.e_type != ET_DYN) return false;
#if defined(__x86_64__)
  if (header.e_machine != EM_X86_64) return false;
#elif defined(__aarch64__)
  if (header.e_machine != EM_AARCH64) return false;
#endif
  file.seekg(static_cast<std::streamoff>(header.e_phoff));
  for (unsigned i = 0; i < header.e_phnum; ++i) {
    ElfW(Phdr) segment{};
    if (!file.read(reinterpret_cast<char*>(&segment), sizeof segment)) return false;
    if (segment.p_type == PT_INTERP) return false;
  }
  return true;
}

std::optional<std::string> read_section(const std::string& path, const std::string& name) {
  constexpr std::size_t kMost = std::size_t{16} << 20;
  std::ifstream file{path, std::ios::binary};
  const auto read_at = [&file](std::uint64_t offset, void* to, std::size_t size) {
    file.clear();
    return file.seekg(static_cast<std::streamoff>(offset)) &&
           file.read(static_cast<char*>(to), static_cast<std::streamsize>(size));
  };
  ElfW(Ehdr) header{};
  if (!read_at(0, &header, sizeof header) || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return {};
  const auto read_header = [&](unsigned index, ElfW(Shdr) & section) {
    return read_at(header.e_shoff + std::uint64_t{index} * sizeof section, &section, sizeof section) &&
           section.sh_size <= kMost && section.sh_type != SHT_NOBITS;
  };
  const auto read_content = [&](const ElfW(Shdr) & section) {
    std::string content(section.sh_size, '\0');
    return read_at(section.sh_offset, content.data(), content.size()) ? content : std::string{};
  };
  ElfW(Shdr) section{};
  if (header.e_shentsize != sizeof section || !read_header(header.e_shstrndx, section)) return {};
  const std::string names = read_content(section);
  for (unsigned i = 1; i < header.e_shnum; ++i) {
    if (!read_header(i, section) || section.sh_name >= names.size()) continue;
    if (name != names.c_str() + section.sh_name) continue;
    if (std::string content = read_content(section); !content.empty()) return content;
  }
  return {};
}

/// Returns the texts of an ELF file's dynamic entries with one of these two tags.
static std::vector<std::string> dynamic_texts(const std::string& path, ElfW(Sxword) one, ElfW(Sxword) other) {
  const std::string entries = read_section(path, ".dynamic").value_or("");
  const std::string names = read_section(path, ".dynstr").value_or("");
  std::vector<std::string> texts;
  ElfW(Dyn) entry{};
  for (std::size_t at = 0; at + sizeof entry <= entries.size(); at += sizeof entry) {
    std::memcpy(&entry, entries.data() + at, sizeof entry);
    if ((entry.d_tag == one || entry.d_tag == other) && entry.d_un.d_val < names.size())
      texts.emplace_back(names.c_str() + entry.d_un.d_val);
  }
  return texts;
}

std::string library_folders(const std::string& path) {
  const auto texts = dynamic_texts(path, DT_RUNPATH, DT_RPATH);
  return texts.empty() ? "" : texts.front();
}

std::vector<std::string> needed_libraries(const std::string& path) {
  return dynamic_texts(path, DT_NEEDED, DT_NEEDED);
}

/// Syncs the folder of a file that was renamed or removed, so that the change survives a loss of power.
static Result<void> sync_folder(const std::string& path) {
  const std::filesystem::path above = std::filesystem::path{path}.parent_path();
  const std::string folder = above.empty() ? "." : above.string();
  const Fd directory{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (!directory || ::fsync(directory.get()) != 0) return errno_problem(folder);
  return {};
}

Result<void> replace_file(const std::string& path, const std::string& content, Readers readers) {
  const std::filesystem::path target{path};
  const std::string folder = target.parent_path().empty() ? "." : target.parent_path().string();
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return error_problem(folder, error.value(), advice_to_write(error.value()));

  const std::string temporary = path + ".new";
  const auto failed = [&] {
    Problem problem = errno_problem(temporary, advice_to_write(errno));
    ::unlink(temporary.c_str());
    return problem;
  };
  ::unlink(temporary.c_str());  // an interrupted call, or another user, may have left it
  Fd file{::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC,
                 readers == Readers::owner ? 0600 : 0644)};
  if (!file) return failed();
  for (std::size_t written = 0; written < content.size();) {
    const ssize_t n = ::write(file.get(), content.data() + written, content.size() - written);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return failed();
    written += static_cast<std::size_t>(n);
  }
  // The content must be on the disk before the rename, and the new name before this function returns.
  if (::fsync(file.get()) != 0) return failed();
  file.close();
  if (::rename(temporary.c_str(), path.c_str()) != 0) return failed();
  return sync_folder(path);
}

Result<std::optional<std::string>> read_file(const std::string& path, std::size_t most) {
  const Fd file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (!file && errno == ENOENT) return std::optional<std::string>{};
  if (!file) return errno_problem(path, "let this user read it");
  std::string content;
  std::array<char, 65536> part{};
  while (content.size() <= most) {
    const ssize_t n = ::read(file.get(), part.data(), part.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno_problem(path);
    if (n == 0) return std::optional<std::string>{std::move(content)};
    content.append(part.data(), static_cast<std::size_t>(n));
  }
  return fail(path + " has more than " + std::to_string(most) + " bytes");
}

std::string text_of(const std::string& path) {
  constexpr std::size_t kMost = std::size_t{16} << 20;
  const auto content = read_file(path, kMost);
  if (!content.ok() || !*content) return {};
  std::string text = **content;
  while (!text.empty() && (text.back() == '\n' || text.back() == '\0')) text.pop_back();
  return text;
}

Result<void> remove_file(const std::string& path) {
  if (::unlink(path.c_str()) == 0) return sync_folder(path);
  return errno == ENOENT ? Result<void>{} : errno_problem(path, "let this user remove it");
}

std::optional<Rights> rights_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  const auto may = [&status](mode_t bit) { return (status.st_mode & bit) != 0; };
  return Rights{.is_folder = S_ISDIR(status.st_mode),
                .group_reads = may(S_IRGRP),
                .group_writes = may(S_IWGRP),
                .others_read = may(S_IROTH),
                .others_write = may(S_IWOTH)};
}

Result<void> make_private_folder(const std::string& path) {
  std::error_code error;
  const std::filesystem::path above = std::filesystem::path{path}.parent_path();
  if (!above.empty()) std::filesystem::create_directories(above, error);
  if (error) return error_problem(above.string(), error.value(), advice_to_write(error.value()));
  if (::mkdir(path.c_str(), 0700) != 0) {
    if (errno != EEXIST) return errno_problem(path, advice_to_write(errno));
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return errno_problem(path);
    if (!S_ISDIR(status.st_mode)) return fail(path + " is a file", "name a folder");
    if ((status.st_mode & 077) != 0)
      return fail("other users may enter the folder " + path, "run chmod 700 " + path);
  }
  return check_writers(path);
}

bool output_is_terminal() { return ::isatty(STDOUT_FILENO) == 1; }

bool output_has_no_reader() {
  pollfd output{.fd = STDOUT_FILENO, .events = 0, .revents = 0};
  return ::poll(&output, 1, 0) == 1;
}

}  // namespace takt::os
