#pragma once
// Whether somebody holds a key: bytes keep coming on standard input.

#include <chrono>
#include <memory>

namespace tiltfeed::daemon {

/// On a terminal keys come one by one and are not shown while it lives.
class HeldKeys {
 public:
  /// Without input for so long nobody is there any more.
  static constexpr std::chrono::milliseconds kPatience{500};

  HeldKeys();
  ~HeldKeys();
  HeldKeys(const HeldKeys&) = delete;
  HeldKeys& operator=(const HeldKeys&) = delete;

  /// Takes what has come. False for good after kPatience without any, and at the end of the input.
  bool held();

 private:
  struct Terminal;
  std::unique_ptr<Terminal> terminal_;
  std::chrono::steady_clock::time_point heard_ = std::chrono::steady_clock::now();
  bool over_ = false;
};

}  // namespace tiltfeed::daemon
