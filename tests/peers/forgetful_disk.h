#pragma once
// A disk that keeps what was synced, and of the rest whatever it likes: between the C library and all that
// this process and its children do beneath one folder, libraries such as SQLite included. Content belongs to
// a file and is kept by that file's sync; names belong to their folder and are kept by the folder's.

#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace tiltfeed {

/// What a call does when its turn has come.
struct DiskFault {
  int call = 0;        ///< counted from 1; 0: none fails
  int error = 0;       ///< ENOSPC: only calls that change something count
  bool after = false;  ///< every later call fails, too
  bool part = false;   ///< a write takes a half of the bytes first
};

/// Properties: a file's content after a power loss is that of its last sync, with any of the later writes and
/// cuts, each whole or torn, in any order; a folder's names likewise, a rename whole or not at all. What was
/// written to a file before a sync that failed is kept or lost, and no later sync brings it back. One at a
/// time.
class ForgetfulDisk {
 public:
  /// Beneath `root` everything that is there is on the disk.
  explicit ForgetfulDisk(std::string root);
  ForgetfulDisk(const ForgetfulDisk&) = delete;
  ForgetfulDisk& operator=(const ForgetfulDisk&) = delete;
  ~ForgetfulDisk();

  /// Calls are counted anew; one may fail.
  void begin(const DiskFault& fault);
  /// Calls since `begin`.
  int calls() const;
  /// The call that failed: its name and its file; empty while none did.
  std::string failed() const;
  /// From here on files grow only by what others give back; those that do not fail with `error`.
  void fill(int error);
  /// From here on no call is counted, none fails, and there is room.
  void rest();
  /// The folder is then what a power loss leaves; without `random` nothing that was not synced.
  void lose_power(std::mt19937_64* random);

 private:
  struct Node;
  using NodePtr = std::shared_ptr<Node>;
  struct Change;
  struct NameChange;

  void take_log();
  void take(std::string_view entry);
  NodePtr look(const std::string& path);
  void leave(Node& node, const std::string& path, std::mt19937_64* random);
  static void settle(Node& node, std::mt19937_64* random);

  std::string root_;
  NodePtr top_;
  std::map<std::uint64_t, NodePtr> by_inode_;
  std::mt19937_64 fate_{1};  ///< of what a failed sync leaves
};

}  // namespace tiltfeed
