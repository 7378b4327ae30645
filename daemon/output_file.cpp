#include "daemon/output_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <set>
#include <utility>

namespace tiltfeed {

namespace {

/// The files of the process, for OutputFile::abandon().
struct Files {
  std::mutex mutex;
  std::set<std::string> unfinished;
  std::string committed;
};
Files& files() {
  static Files all;
  return all;
}

}  // namespace

OutputFile::OutputFile(const std::string& path)
    : path_(path), temporary_(path + ".part-" + std::to_string(getpid())), out_() {
  const std::lock_guard lock(files().mutex);
  files().unfinished.insert(temporary_);
  out_.open(temporary_, std::ios::binary);
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::exchange(other.temporary_, {})),
      out_(std::move(other.out_)) {}

OutputFile::~OutputFile() {
  if (temporary_.empty()) return;
  std::remove(temporary_.c_str());
  const std::lock_guard lock(files().mutex);
  files().unfinished.erase(temporary_);
}

Result<OutputFile> OutputFile::open(const std::string& path) {
  OutputFile file(path);
  if (!file.out_) {
    const std::string reason = std::strerror(errno);
    return fail(Code::kIo, path + ": cannot be written: " + reason + "; choose another folder");
  }
  return file;
}

Result<void> OutputFile::commit() {
  out_.close();
  if (out_.fail())
    return fail(Code::kIo, path_ + ": writing failed (is the disk full?); nothing was left behind");
  const std::lock_guard lock(files().mutex);
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0)
    return fail(Code::kIo, path_ + ": cannot be replaced: " + std::strerror(errno));
  files().unfinished.erase(temporary_);
  files().committed += (files().committed.empty() ? "" : ", ") + path_;
  temporary_.clear();
  return {};
}

std::string OutputFile::abandon() {
  files().mutex.lock();  // for good
  for (const std::string& name : files().unfinished) std::remove(name.c_str());
  return files().committed;
}

}  // namespace tiltfeed
