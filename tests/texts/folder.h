#pragma once
// A folder of a test's own.

#include <unistd.h>

#include <filesystem>
#include <fstream>
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

}  // namespace tiltfeed
