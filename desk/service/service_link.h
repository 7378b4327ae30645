#pragma once
// The requests to the service that are in work.

#include <functional>
#include <list>
#include <string>
#include <vector>

#include "desk/service/service_call.h"

namespace tiltfeed::desk {

/// The reply as JSON text, which has "ok": true. Errors: kIo: the service does not answer; kUsage: it
/// refuses, in its words; kLimit: too many requests are in work.
using Answered = std::function<void(const Result<std::string>&)>;

class ServiceLink {
 public:
  static constexpr std::size_t kMost = 32;

  explicit ServiceLink(std::string socket) : socket_(std::move(socket)) {}

  bool is_named() const { return !socket_.empty(); }
  const std::string& socket() const { return socket_; }
  /// `json`: the request as one object. `answered` is called once: here where it fails at once, else in
  /// hear(); it may ask again.
  void ask(const std::string& json, Answered answered, const std::vector<int>& files = {});
  std::vector<int> descriptors() const;
  /// False: this descriptor is not ours.
  bool hear(int descriptor);

 private:
  struct Asked {
    ServiceCall call;
    Answered answered;
  };
  std::string socket_;
  std::list<Asked> asked_;
};

}  // namespace tiltfeed::desk
