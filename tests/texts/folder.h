#pragma once
// A folder of a test's own, and what a file holds.

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace tiltfeed {

/// Empty at first, removed with what is in it at the end; `name` tells tests of one process apart.
struct Folder {
  explicit Folder(const std::string& name)
      : path("/tmp/tiltfeed_" + name + "_" + std::to_string(::getpid())) {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  /// The file's path.
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path + "/" + name, std::ios::binary) << text;
    return path + "/" + name;
  }
  const std::string path;
};

/// All of the file; nothing where there is none.
inline std::string file_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace tiltfeed
