#pragma once
// The service's Unix socket: who asks, whole lines, files that come along. And the client's end of it.

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "kinematics/result.h"

struct pollfd;

namespace tiltfeed {

/// One request line of `user` (by the kernel's word) with the files that came with it; returns the reply
/// line.
using ApiAnswer =
    std::function<std::string(const std::string& line, std::uint32_t user, const std::vector<int>& files)>;

/// Properties: at most kClients at once, kMaxRequest bytes a line, two files a request; a client that neither
/// asks nor reads for kPatience is dropped; files are closed after their request.
class ApiSocket {
 public:
  static constexpr std::size_t kClients = 32;
  static constexpr std::chrono::seconds kPatience{10};

  /// A socket file with mode 0660; one that a dead service left is replaced. Errors: kIo, also when another
  /// service answers there.
  static Result<ApiSocket> open(const std::string& path);
  ApiSocket(ApiSocket&& other) noexcept;
  ApiSocket& operator=(ApiSocket&&) = delete;
  ~ApiSocket();

  /// What to poll; then the same with revents filled in.
  void add_to(std::vector<pollfd>& polled) const;
  void serve(const std::vector<pollfd>& polled, const ApiAnswer& answer);

 private:
  struct Client {
    int fd = -1;
    std::uint32_t user = 0;
    std::string in, out;
    std::vector<int> files;
    std::chrono::steady_clock::time_point heard;
  };
  ApiSocket(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}
  void accept_client();
  bool talk(Client& client, short events, const ApiAnswer& answer);
  bool receive(Client& client);
  static void close_files(Client& client);

  std::string path_;
  int fd_ = -1;
  std::vector<Client> clients_;
};

/// Sends one request line with files and waits for the reply line. Errors: kIo: nobody listens, or no answer.
Result<std::string> ask_service(const std::string& socket, const std::string& line,
                                const std::vector<int>& files);

}  // namespace tiltfeed
