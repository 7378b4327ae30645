#pragma once
// Users' files are read by a process of its own: whatever hangs, grows or is no file touches no loop.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Descriptors that a user handed over. Closing one may take as long as its file system likes: a thread of
/// its own does that.
class HandedFiles {
 public:
  explicit HandedFiles(std::vector<int> files = {}) : files_(std::move(files)) {}
  HandedFiles(HandedFiles&& other) noexcept : files_(std::exchange(other.files_, {})) {}
  HandedFiles& operator=(HandedFiles&& other) noexcept {
    std::swap(files_, other.files_);
    return *this;
  }
  ~HandedFiles();
  const std::vector<int>& all() const { return files_; }
  void add(int file) { files_.push_back(file); }

 private:
  std::vector<int> files_;
};

struct CopyItem {
  int from = -1;
  std::string name;         ///< of the copy, beneath the folder; nothing is there yet
  std::uint64_t limit = 0;  ///< bytes
};

/// Properties: at most kMemory of memory, `limit` bytes of each file, `patience` of time; regular files only;
/// dies with the process that started it.
class CopyProcess {
 public:
  static constexpr std::size_t kMemory = 65536;
  static constexpr std::chrono::seconds kPatience{300};

  /// Errors: kIo.
  static Result<CopyProcess> start(const std::string& folder, const std::vector<CopyItem>& items,
                                   std::chrono::milliseconds patience = kPatience);
  CopyProcess(CopyProcess&& other) noexcept;
  CopyProcess& operator=(CopyProcess&&) = delete;
  ~CopyProcess();

  /// Nothing while it runs; afterwards how it ended, once. Errors: kInput (no regular file, too large, too
  /// slow), kIo.
  std::optional<Result<void>> check();

 private:
  CopyProcess(int pid, int report, std::vector<CopyItem> items, std::chrono::milliseconds patience)
      : pid_(pid), report_(report), items_(std::move(items)), patience_(patience) {}
  Result<void> outcome() const;

  int pid_ = -1;
  int report_ = -1;
  std::vector<CopyItem> items_;
  std::chrono::milliseconds patience_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

}  // namespace tiltfeed::daemon
