#include "scratch_folder.hpp"

#include <fstream>

#include <takt/os/environment.hpp>

namespace takt::bench {

namespace fs = std::filesystem;

Result<ScratchFolder> ScratchFolder::create() {
  static int count = 0;
  std::error_code error;
  const fs::path path = fs::temp_directory_path(error) /
                        ("takt-bench-" + std::to_string(os::process_id()) + "-" + std::to_string(++count));
  if (error || !fs::create_directory(path, error))
    return fail("cannot create the folder " + path.string(), "set TMPDIR to another folder");
  return ScratchFolder{path};
}

Result<std::string> ScratchFolder::write(const std::string& name, const std::string& content) const {
  const std::string path = file(name);
  std::ofstream out{path, std::ios::binary};
  out << content;
  out.close();
  if (!out)
    return fail(path + " cannot be written", "free space on the disk, or set TMPDIR to another folder");
  return path;
}

}  // namespace takt::bench
