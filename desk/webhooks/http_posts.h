#pragma once
// Requests to receivers that are in work: one for each lane, by libcurl.

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

struct PostAnswer {
  int status = 0;                           ///< 0: no answer
  std::string why;                          ///< why there is none
  std::string said;                         ///< how its body begins, printable ASCII on one line
  std::optional<std::int64_t> retry_after;  ///< s
};

struct PostLimits {
  std::chrono::milliseconds connect{5000}, whole{15'000};
  std::size_t answer = 65536;  ///< bytes of head and body; what comes after is not read
};

/// Properties: http and https alone, HTTP/1.1, certificates checked by the system's list; follows no
/// redirect, uses no proxy, keeps no connection. An answer counts as soon as its status is known.
class HttpPosts {
 public:
  /// Errors: kIo.
  static Result<HttpPosts> make(PostLimits limits = {});
  HttpPosts(HttpPosts&& other) noexcept;
  HttpPosts& operator=(HttpPosts&&) = delete;
  ~HttpPosts();

  /// Requires: this lane has none in work. False: it cannot be begun (no memory).
  bool start(std::size_t lane, const std::string& url, const std::vector<std::string>& headers,
             const std::string& body);
  /// Until something is to be done for a request, one of the descriptors is readable, wake() was called, or
  /// the time is over.
  void wait(std::chrono::milliseconds most, const std::vector<int>& descriptors);
  /// From any thread.
  void wake();
  struct Ended {
    std::size_t lane;
    PostAnswer answer;
  };
  /// Works on the requests; those that have ended.
  std::vector<Ended> turn();

 private:
  struct State;
  explicit HttpPosts(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tiltfeed::desk
