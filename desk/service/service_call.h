#pragma once
// One request to the service, over a connection of its own.

#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

/// Property: nothing here waits.
class ServiceCall {
 public:
  /// A reply longer than this is none.
  static constexpr std::size_t kMaxReply = 4u << 20;

  /// Sends the line; the service gets copies of the descriptors. Errors: kIo: nobody listens there.
  static Result<ServiceCall> start(const std::string& socket, const std::string& line,
                                   const std::vector<int>& files);
  ServiceCall(ServiceCall&& other) noexcept;
  ServiceCall& operator=(ServiceCall&&) = delete;
  ~ServiceCall();

  /// Readable when there is something to hear.
  int descriptor() const { return fd_; }
  /// The reply, one line, once all of it is there. Errors: kIo: the connection was closed before.
  std::optional<Result<std::string>> hear();

 private:
  explicit ServiceCall(int fd) : fd_(fd) {}
  int fd_ = -1;
  std::string got_;
};

}  // namespace tiltfeed::desk
