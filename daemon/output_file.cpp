#include "daemon/output_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace tiltfeed {

OutputFile::OutputFile(const std::string& path)
    : path_(path),
      temporary_(path + ".part-" + std::to_string(getpid())),
      out_(temporary_, std::ios::binary) {}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, {})),
      out_(std::move(other.out_)) {}

OutputFile::~OutputFile() {
  if (!temporary_.empty()) std::remove(temporary_.c_str());
}

Result<OutputFile> OutputFile::open(const std::string& path) {
  OutputFile file(path);
  if (!file.out_) {
    const std::string reason = std::strerror(errno);
    file.temporary_.clear();
    return fail(Code::kIo, path + ": cannot be written: " + reason + "; choose another folder");
  }
  return file;
}

Result<void> OutputFile::commit() {
  out_.close();
  if (out_.fail())
    return fail(Code::kIo, path_ + ": writing failed (is the disk full?); nothing was left behind");
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0)
    return fail(Code::kIo, path_ + ": cannot be replaced: " + std::strerror(errno));
  temporary_.clear();
  return {};
}

}  // namespace tiltfeed
