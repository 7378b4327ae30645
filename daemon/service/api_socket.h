#pragma once
// The service's Unix socket: who asks, whole lines, files that come along. And the client's end of it.

#include <chrono>
#include <cstdint>
#include <functional>
#include <list>
#include <string>
#include <vector>

#include "daemon/service/copy_process.h"
#include "kinematics/basics/result.h"

struct pollfd;

namespace tiltfeed::daemon {

/// One request line of `user` (by the kernel's word) with the files that came with it.
struct Asked {
  std::uint64_t client = 0;  ///< whom to reply to
  std::string line;
  std::uint32_t user = 0;
  HandedFiles files;
};
using ApiTaker = std::function<void(Asked)>;

/// Properties: kMaxRequest bytes a line, two files a request; a client asks again when it has its reply; one
/// that neither asks nor reads for kPatience is dropped. At most kClients that wait for nothing: the one that
/// comes next has a place, and who has been silent for longest loses it. At most kWaiting more that wait for
/// a reply; whoever asks then is told so.
class ApiSocket {
 public:
  static constexpr std::size_t kClients = 32, kWaiting = 64;
  static constexpr std::chrono::seconds kPatience{10};

  /// A socket file with mode 0660; one that a dead service left is replaced. Errors: kIo, also when another
  /// service answers there.
  static Result<ApiSocket> open(const std::string& path);
  ApiSocket(ApiSocket&& other) noexcept;
  ApiSocket& operator=(ApiSocket&&) = delete;
  ~ApiSocket();

  /// What to poll; then the same with revents filled in.
  void add_to(std::vector<pollfd>& polled) const;
  void serve(const std::vector<pollfd>& polled, const ApiTaker& take);
  /// A line, to who asked; nothing where that one has gone.
  void reply(std::uint64_t client, const std::string& line, const ApiTaker& take);
  /// Clients that wait for their reply.
  std::size_t waiting() const;

 private:
  struct Client {
    int fd = -1;
    std::uint64_t id = 0;
    std::uint32_t user = 0;
    std::string in, out;
    HandedFiles files;
    std::chrono::steady_clock::time_point heard;
    bool waits = false;     // for its reply
    bool taken_of = false;  // its lines are being taken
    bool gone = false;
  };
  ApiSocket(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}
  void accept_clients();
  void make_room();
  bool talk(Client& client, short events, const ApiTaker& take);
  bool send_out(Client& client);
  bool take_lines(Client& client, const ApiTaker& take);
  bool receive(Client& client);

  std::string path_;
  int fd_ = -1;
  std::uint64_t last_ = 0;  // number of a client
  std::list<Client> clients_;
};

/// Sends one request line with files and waits for the reply line. Errors: kIo: nobody listens; kLink: no
/// answer within `patience`, without one as long as a submission may take.
Result<std::string> ask_service(const std::string& socket, const std::string& line,
                                const std::vector<int>& files, std::chrono::seconds patience);
Result<std::string> ask_service(const std::string& socket, const std::string& line,
                                const std::vector<int>& files);
/// Of who only wants to know whether a service is alive.
inline constexpr std::chrono::seconds kShortPatience{10};

}  // namespace tiltfeed::daemon
