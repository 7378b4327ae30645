#pragma once
// What the calls beneath the watched folder leave for ForgetfulDisk: in memory that children share.

#include <cstddef>
#include <cstdint>
#include <string>

#include "tests/peers/forgetful_disk.h"

namespace tiltfeed {

enum class DiskOp : char {
  kMake = 'm',
  kFolder = 'f',
  kWrite = 'w',
  kCut = 'c',
  kSync = 's',
  kNoSync = 'n',
  kUnlink = 'u',
  kRename = 'r'
};

/// Before an entry's text: a name, two names with a slash between them, or the bytes.
struct DiskEntry {
  DiskOp op = DiskOp::kMake;
  std::uint64_t inode = 0;   ///< of the file, or of what was made
  std::uint64_t folder = 0;  ///< of the name
  std::uint64_t at = 0;      ///< of the bytes, or the size
  std::uint64_t size = 0;    ///< of the text
};

inline constexpr std::size_t kDiskLog = 32u << 20;

struct DiskCalls {
  bool watching = false, failing = false;
  bool full = false;       ///< files grow by `room` at most
  int full_error = 0;      ///< of those that would grow further
  std::uint64_t room = 0;  ///< bytes
  char root[512] = {};
  DiskFault fault;
  int calls = 0;
  char failed[600] = {};
  std::size_t used = 0;
  char log[kDiskLog] = {};
};
/// Shared with children.
DiskCalls& disk_calls();

}  // namespace tiltfeed
