#pragma once
// The folder into which programs are moved that are to be submitted.

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "daemon/service/copy_process.h"

namespace tiltfeed::daemon {

/// Device, inode, size and time of change: what tells a file from itself later, and from another of its name.
using FileStamp = std::array<std::int64_t, 5>;
/// Files of a watched folder, by path, as they were when they were taken or refused.
using SeenFiles = std::map<std::string, FileStamp>;

struct WatchedFolder {
  std::string trouble;                 ///< why it cannot be read; else empty
  SeenFiles seen;                      ///< of those that were seen before, who is still there as it was
  std::string path;                    ///< the first by name that was not; empty: there is none
  FileStamp stamp = {};                ///< of that
  std::shared_ptr<HandedFiles> files;  ///< that, open
};

/// Programs only: regular files NAME.nc, no links. May take as long as its file system likes.
WatchedFolder look_into(const std::string& folder, const SeenFiles& seen);
/// Removes what was taken, unless another has come in its place. False: it cannot be removed.
bool remove_taken(const std::string& path, const FileStamp& stamp);

}  // namespace tiltfeed::daemon
