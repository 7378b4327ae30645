#pragma once
// Passwords checked in a child, one at a time, so that nobody else waits for a hash.

#include <chrono>
#include <deque>
#include <functional>
#include <string>

namespace tiltfeed::desk {

/// Properties: at most kWaiting wait; after kFailures within kPeriod every password is refused unheard until
/// the first of them is older; the child has none of our descriptors, and its end is a no.
class PasswordCheck {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Checked = std::function<void(bool)>;
  static constexpr std::size_t kWaiting = 8, kFailures = 10;
  static constexpr std::chrono::seconds kPeriod{60};

  PasswordCheck() = default;
  PasswordCheck(const PasswordCheck&) = delete;
  PasswordCheck& operator=(const PasswordCheck&) = delete;
  ~PasswordCheck();

  /// `known` false: the hash is made up, and the answer is no. `checked` is called once, out of hear().
  /// False: not now, and it is never called.
  bool ask(const std::string& password, const std::string& hash, bool known, Checked checked, Time now);
  /// Readable when there is something to hear; -1: nothing is in work.
  int descriptor() const { return hear_; }
  void hear(Time now);

 private:
  struct Asked {
    std::string password, hash;
    bool known;
    Checked checked;
  };
  bool begin_next();
  std::deque<Asked> asked_;  // the first is in work
  std::deque<Time> failures_;
  int pid_ = -1, hear_ = -1;
};

}  // namespace tiltfeed::desk
