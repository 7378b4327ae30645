#pragma once
// The dead man's switch of a jog: it goes on as long as the page says that the key is held.

#include <chrono>
#include <cstdint>

namespace tiltfeed::desk {

class HeldJog {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// So long after the last beat the jog is to end.
  static constexpr std::chrono::milliseconds kPatience{300};

  /// `owner`: the session that holds the key.
  void begin(std::uint64_t owner, Time now);
  /// False: there is no jog of this owner, or it is to end already.
  bool beat(std::uint64_t owner, Time now);
  /// The key was let go: the same as silence.
  void let_go(std::uint64_t owner);
  /// The machine has ended it.
  void end() { owner_ = 0; }

  bool is_held() const { return owner_ != 0 && !over_; }
  /// The key is held down now.
  bool lives(Time now) const { return is_held() && !let_go_ && now < due(); }
  /// True once for each jog: now it has to be stopped.
  bool is_due(Time now);
  Time due() const { return beat_ + kPatience; }

 private:
  std::uint64_t owner_ = 0;  // 0: there is no jog
  Time beat_;
  bool let_go_ = false, over_ = false;
};

}  // namespace tiltfeed::desk
