#pragma once
// An HTTP/1.1 server on this computer's own addresses: one thread, which is the caller's.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "desk/http/http_message.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

struct HttpOptions {
  std::uint16_t port = 0;                  ///< 0: a free one
  std::string upload_folder;               ///< where file bodies are put while they arrive
  std::string address = "127.0.0.1";       ///< IPv4
  std::string certificate = "", key = "";  ///< TLS: chain and key, PEM; empty: none
  bool behind_proxy = false;               ///< all come from its address
};

/// Who answers. Both are called in turn(), never inside each other.
struct HttpCalls {
  /// As soon as the head of a request is read: the refusal, or nothing, and `rule` filled in.
  std::function<std::optional<Reply>(const Request&, BodyRule& rule)> admit;
  std::function<Reply(const Request&)> answer;
};

/// Properties:
/// 1 At most kConnections, kPerAddress from one address that is no proxy's, kStreams of events; who comes
///   then is refused.
/// 2 A connection that has sent no whole request kHeadPatience after it was opened, or after its last one,
///   is closed, however busy it is; so is a body that takes longer than kHeadPatience and its length at
///   kSlowestBody.
/// 3 A body over its rule is refused before a byte of it is read.
/// 4 A request that is answered later waits for finish(); at most kLater of them, more are refused.
/// 5 A listener hears something every kBeat, so that one that is gone is noticed.
class HttpServer {
 public:
  static constexpr unsigned kConnections = 128, kPerAddress = 40;
  static constexpr std::size_t kStreams = 48, kLater = 32;
  /// Connections that were not given anything of the API: of more the oldest is closed.
  static constexpr std::ptrdiff_t kStrangers = 20;
  static constexpr std::chrono::seconds kHeadPatience{10}, kBeat{10};
  static constexpr double kSlowestBody = 1e6;  ///< bytes/s

  /// Errors: kIo: the port is taken, or TLS does not like certificate and key; kUsage.
  static Result<HttpServer> open(const HttpOptions& options, HttpCalls calls);
  HttpServer(HttpServer&& other) noexcept;
  HttpServer& operator=(HttpServer&&) = delete;
  ~HttpServer();

  std::uint16_t port() const;
  /// Readable when there is something to do; and after so many milliseconds at most turn() is due.
  int descriptor() const;
  int patience_ms() const;
  void turn();

  /// To all that listen; written at the next turn().
  void tell(const std::string& event, const std::string& json);
  std::size_t listeners() const;
  /// The reply to a request that was answered with `later`; nothing where the client has gone.
  void finish(std::uint64_t ticket, const Reply& reply);

  struct State;

 private:
  explicit HttpServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tiltfeed::desk
