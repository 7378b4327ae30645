#pragma once
// What a power loss may not take.

#include <string>

namespace tiltfeed::daemon {

/// A name in this folder survives a power loss from here on: its file's own sync does not see to that. -errno
/// when it fails.
int sync_folder(const std::string& folder);
/// Makes the folder and those above it that are not there, and their names durable. -errno when it fails.
int make_folders(const std::string& path);

}  // namespace tiltfeed::daemon
