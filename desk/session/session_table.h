#pragma once
// Who is signed in: one-time tokens, and the sessions that they became.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

struct Session {
  std::uint64_t number = 0;  ///< from 1, never used twice
  std::string cookie, csrf;
  std::chrono::steady_clock::time_point seen;
  std::string user = {};  ///< empty: signed in by a token
  bool operates = true;   ///< else watches only
};

/// Properties: a token opens one session and is then worth nothing; the newest token is the only one. At most
/// kSessions: the one that was silent for longest goes.
class SessionTable {
 public:
  static constexpr std::size_t kSessions = 64;

  /// A token that opens one session. Errors: kIo.
  Result<std::string> new_token();
  /// Nothing where the token is not the newest, or was used. Errors: kIo.
  Result<std::optional<Session>> open(const std::string& token);
  /// A session for a user whose password was right. Errors: kIo.
  Result<Session> open_for(const std::string& user, bool operates);
  /// Nothing where there is no such session; valid until the next call of open().
  const Session* number(std::uint64_t number) const;
  /// The session of a cookie, or null; valid until the next call of open().
  const Session* find(const std::string& cookie);
  void close(const std::string& cookie);

 private:
  std::string token_;  // empty: none
  std::uint64_t last_ = 0;
  std::vector<Session> sessions_;
};

}  // namespace tiltfeed::desk
