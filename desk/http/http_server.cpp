#include "desk/http/http_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <microhttpd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <list>
#include <map>
#include <set>

#include "desk/http/access_check.h"
#include "desk/http/event_ring.h"
#include "desk/http/http_head.h"

namespace tiltfeed::desk {
namespace {

using Clock = std::chrono::steady_clock;

/// The page runs under this; nothing is loaded from elsewhere, no text becomes script or style.
constexpr char kPolicy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
constexpr std::pair<const char*, const char*> kAlways[] = {{"Content-Security-Policy", kPolicy},
                                                           {"X-Content-Type-Options", "nosniff"},
                                                           {"Referrer-Policy", "no-referrer"},
                                                           {"Cross-Origin-Opener-Policy", "same-origin"},
                                                           {"Cross-Origin-Resource-Policy", "same-origin"}};
constexpr char kPriorities[] = "NORMAL:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2";
constexpr int kIdleSeconds = 30;  // without a byte either way
constexpr std::size_t kStreamBlock = 4096;

struct Connection {
  int fd = -1;
  bool asking = false;    // a request is being answered
  bool known = false;     // something of the API was answered
  Clock::time_point due;  // when the next whole request has to be there
};

}  // namespace

struct HttpServer::State {
  struct Exchange {
    Request request;
    BodyRule rule;
    int file = -1;
    std::uint64_t got = 0;
    std::optional<Reply> refused;
    std::optional<Reply> finished;  // what came later
    MHD_Connection* waits = nullptr;
  };
  struct Stream {
    State* state;
    MHD_Connection* connection;
    EventPlace place;
    bool asleep = false;
  };

  HttpOptions options;
  HttpCalls calls;
  MHD_Daemon* daemon = nullptr;
  EventRing ring;
  std::list<Connection> connections;
  std::set<Stream*> streams;
  std::set<Exchange*> exchanges;
  std::map<std::uint64_t, Exchange*> later;  // by ticket
  std::uint64_t tickets = 0;
  bool news = false;
  std::uint64_t uploads = 0;
  Clock::time_point beat = Clock::now();

  void wake() {
    news = false;
    for (Stream* stream : streams) {
      if (!stream->asleep) continue;
      stream->asleep = false;
      MHD_resume_connection(stream->connection);
    }
  }

  ~State() {
    if (!daemon) return;
    while (!later.empty()) finish(later.begin()->first, refusal(503, "tiltfeed desk is ending"));
    wake();  // a daemon that is stopped with a suspended connection aborts the process
    MHD_stop_daemon(daemon);
    for (Exchange* exchange : exchanges) drop(exchange);
  }

  static void drop(Exchange* exchange) {
    if (exchange->file >= 0) ::close(exchange->file);
    if (!exchange->request.file.empty()) ::unlink(exchange->request.file.c_str());
    delete exchange;
  }

  Connection* connection_of(MHD_Connection* connection) {
    const MHD_ConnectionInfo* info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    return info ? static_cast<Connection*>(info->socket_context) : nullptr;
  }

  MHD_Result queue(MHD_Connection* connection, const Reply& reply) {
    if (reply.events) return queue_events(connection, reply);
    MHD_Response* response = nullptr;
    int status = reply.status;
    if (!reply.file.empty()) {
      response = response_of(reply.file);
      if (!response)
        return queue(connection, refusal(404, "there is no such file any more; reload the page"));
    } else if (!reply.bytes.empty()) {
      response = MHD_create_response_from_buffer(reply.bytes.size(), const_cast<char*>(reply.bytes.data()),
                                                 MHD_RESPMEM_PERSISTENT);
    } else {
      response = MHD_create_response_from_buffer(reply.body.size(), const_cast<char*>(reply.body.data()),
                                                 MHD_RESPMEM_MUST_COPY);
    }
    return send(connection, response, reply, status);
  }

  static MHD_Response* response_of(const std::string& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    struct stat about {};
    if (fd < 0) return nullptr;
    if (::fstat(fd, &about) != 0 || !S_ISREG(about.st_mode)) return ::close(fd), nullptr;
    MHD_Response* response = MHD_create_response_from_fd64(static_cast<std::uint64_t>(about.st_size), fd);
    if (!response) ::close(fd);
    return response;
  }

  static MHD_Result send(MHD_Connection* connection, MHD_Response* response, const Reply& reply, int status) {
    if (!response) return MHD_NO;
    if (!reply.type.empty()) MHD_add_response_header(response, "Content-Type", reply.type.c_str());
    bool cached = false;
    for (const auto& [name, value] : reply.headers) {
      MHD_add_response_header(response, name.c_str(), value.c_str());
      cached = cached || name == "Cache-Control";
    }
    if (!cached) MHD_add_response_header(response, "Cache-Control", "no-store");
    for (const auto& [name, value] : kAlways) MHD_add_response_header(response, name, value);
    const MHD_Result queued = MHD_queue_response(connection, static_cast<unsigned>(status), response);
    MHD_destroy_response(response);
    return queued;
  }

  MHD_Result queue_events(MHD_Connection* connection, const Reply& reply) {
    if (streams.size() >= kStreams)
      return queue(connection,
                   refusal(503, "more than " + std::to_string(kStreams) + " pages listen; close some"));
    auto* stream = new Stream{
        this, connection, ring.start_after(reply.events_after.has_value(), reply.events_after.value_or(0))};
    MHD_Response* response = MHD_create_response_from_callback(
        MHD_SIZE_UNKNOWN, kStreamBlock, &State::read_events, stream, &State::end_events);
    if (!response) return delete stream, MHD_NO;
    streams.insert(stream);
    Reply head = reply;
    head.type = "text/event-stream";
    return send(connection, response, head, 200);
  }

  static ssize_t read_events(void* own, std::uint64_t, char* out, std::size_t most) {
    auto* stream = static_cast<Stream*>(own);
    const EventRing& ring = stream->state->ring;
    if (ring.lost(stream->place)) return MHD_CONTENT_READER_END_OF_STREAM;
    if (const std::size_t count = ring.read(stream->place, out, most); count > 0)
      return static_cast<ssize_t>(count);
    stream->asleep = true;
    MHD_suspend_connection(stream->connection);
    return 0;
  }

  static void end_events(void* own) {
    auto* stream = static_cast<Stream*>(own);
    stream->state->streams.erase(stream);
    delete stream;
  }

  /// Of a body; what does not fit is refused when all of it has been read.
  void take(Exchange& exchange, const char* data, std::size_t size) {
    exchange.got += size;
    if (exchange.refused) return;
    if (exchange.got > exchange.rule.most) {
      exchange.refused = refusal(413, "the body is longer than its Content-Length");
    } else if (!exchange.rule.file) {
      exchange.request.body.append(data, size);
    } else {
      for (std::size_t done = 0; done < size;) {
        const ssize_t wrote = ::write(exchange.file, data + done, size - done);
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote < 0) {
          exchange.refused = refusal(507, std::string("the upload cannot be kept: ") + std::strerror(errno));
          return;
        }
        done += static_cast<std::size_t>(wrote);
      }
    }
  }

  MHD_Result begin(MHD_Connection* connection, Exchange& exchange) {
    Connection* own = connection_of(connection);
    exchange.refused = calls.admit(exchange.request, exchange.rule);
    const std::uint64_t length = exchange.request.length.value_or(0);
    if (!exchange.refused && length > exchange.rule.most)
      exchange.refused = refusal(413, "the body has " + std::to_string(length) + " bytes; at most " +
                                          std::to_string(exchange.rule.most) + " are taken here");
    if (exchange.refused)  // a body is not waited for
      return length > 0 || !exchange.request.transfer_encoding.empty() ? queue(connection, *exchange.refused)
                                                                       : MHD_YES;
    if (own) {
      const auto body = std::chrono::duration<double>(static_cast<double>(length) / kSlowestBody);
      own->due = Clock::now() + kHeadPatience + std::chrono::duration_cast<Clock::duration>(body);
      // Its body may take its time: who is signed in sends it.
      own->known =
          own->known || (exchange.request.path.starts_with("/api/") && exchange.request.path != kSignIn);
    }
    if (!exchange.rule.file) return MHD_YES;
    exchange.request.file = options.upload_folder + "/upload-" + std::to_string(++uploads);
    exchange.file = ::open(exchange.request.file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (exchange.file < 0)
      exchange.refused = refusal(507, std::string("the upload cannot be kept: ") + std::strerror(errno));
    return MHD_YES;
  }

  MHD_Result end(MHD_Connection* connection, Exchange& exchange) {
    if (Connection* own = connection_of(connection)) own->asking = true;
    if (exchange.file >= 0) ::close(exchange.file), exchange.file = -1;
    if (exchange.refused) return queue(connection, *exchange.refused);
    if (exchange.finished) return queue(connection, *exchange.finished);
    if (later.size() >= kLater) return queue(connection, refusal(503, "too many requests wait; ask again"));
    exchange.request.ticket = ++tickets;
    later.emplace(tickets, &exchange);
    Reply reply = calls.answer(exchange.request);
    if (Connection* own = connection_of(connection); own && reply.status < 400)
      own->known = own->known || exchange.request.path.starts_with("/api/");
    reply.events_after = exchange.request.last_event_id;
    if (!reply.later) {
      later.erase(exchange.request.ticket);
      return queue(connection, reply);
    }
    if (exchange.finished) return queue(connection, *exchange.finished);
    exchange.waits = connection;
    MHD_suspend_connection(connection);
    return MHD_YES;
  }

  void finish(std::uint64_t ticket, const Reply& reply) {
    const auto found = later.find(ticket);
    if (found == later.end()) return;
    Exchange& exchange = *found->second;
    later.erase(found);
    exchange.finished = reply;
    if (!exchange.waits) return;
    MHD_resume_connection(exchange.waits);
    exchange.waits = nullptr;
    news = true;
  }

  static MHD_Result on_request(void* own, MHD_Connection* connection, const char* url, const char* method,
                               const char*, const char* data, std::size_t* size, void** mine) {
    auto* state = static_cast<State*>(own);
    if (!*mine) {
      auto* exchange = new Exchange();
      exchange->request = head_of(connection, url, method);
      *mine = exchange;
      state->exchanges.insert(exchange);
      return state->begin(connection, *exchange);
    }
    auto& exchange = *static_cast<Exchange*>(*mine);
    if (*size == 0) return state->end(connection, exchange);
    state->take(exchange, data, *size);
    *size = 0;
    return MHD_YES;
  }

  static void on_completed(void* own, MHD_Connection* connection, void** mine, MHD_RequestTerminationCode) {
    auto* state = static_cast<State*>(own);
    if (auto* exchange = static_cast<Exchange*>(*mine)) {
      state->exchanges.erase(exchange);
      state->later.erase(exchange->request.ticket);
      drop(exchange);
    }
    *mine = nullptr;
    if (Connection* at = state->connection_of(connection))
      at->asking = false, at->due = Clock::now() + kHeadPatience;
  }

  static void on_connection(void* own, MHD_Connection* connection, void** mine,
                            MHD_ConnectionNotificationCode code) {
    auto* state = static_cast<State*>(own);
    if (code == MHD_CONNECTION_NOTIFY_STARTED) {
      const MHD_ConnectionInfo* info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
      state->keep_strangers(kStrangers - 1);
      state->connections.push_back(
          {info ? info->connect_fd : -1, false, false, Clock::now() + kHeadPatience});
      *mine = &state->connections.back();
    } else {
      state->connections.remove_if([&](const Connection& at) { return &at == *mine; });
      *mine = nullptr;
    }
  }

  static bool is_stranger(const Connection& at) {
    char next = 0;  // a request that has come and was not read yet
    return !at.asking && !at.known && at.fd >= 0 && ::recv(at.fd, &next, 1, MSG_PEEK | MSG_DONTWAIT) <= 0;
  }

  /// Whoever opens connections, and says nothing or no whole request, shuts no page out.
  void keep_strangers(std::ptrdiff_t most) {
    for (auto more = std::count_if(connections.begin(), connections.end(), is_stranger) - most; more > 0;
         --more) {
      const auto oldest = std::find_if(connections.begin(), connections.end(), is_stranger);
      if (oldest == connections.end()) return;
      ::shutdown(oldest->fd, SHUT_RDWR);
      oldest->fd = -1;
    }
  }

  void close_slow() {
    const auto now = Clock::now();
    for (const Connection& at : connections)
      if (!at.asking && now > at.due && at.fd >= 0) ::shutdown(at.fd, SHUT_RDWR);
  }
};

HttpServer::HttpServer(std::unique_ptr<State> state) : state_(std::move(state)) {}
HttpServer::HttpServer(HttpServer&& other) noexcept = default;
HttpServer::~HttpServer() = default;

Result<HttpServer> HttpServer::open(const HttpOptions& options, HttpCalls calls) {
  auto state = std::make_unique<State>();
  state->options = options;
  state->calls = std::move(calls);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(options.port);
  if (::inet_pton(AF_INET, options.address.c_str(), &address.sin_addr) != 1)
    return fail(Code::kUsage, options.address + " is no IPv4 address");
  const bool tls = !options.certificate.empty();
  const std::vector<MHD_OptionItem> secure = {
      {MHD_OPTION_HTTPS_MEM_CERT, 0, const_cast<char*>(options.certificate.c_str())},
      {MHD_OPTION_HTTPS_MEM_KEY, 0, const_cast<char*>(options.key.c_str())},
      {MHD_OPTION_HTTPS_PRIORITIES, 0, const_cast<char*>(kPriorities)},
      {MHD_OPTION_END, 0, nullptr}};
  MHD_OptionItem plain{MHD_OPTION_END, 0, nullptr};
  errno = 0;
  state->daemon = MHD_start_daemon(
      MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME | (tls ? static_cast<unsigned>(MHD_USE_TLS) : 0U),
      options.port, nullptr, nullptr, &State::on_request, state.get(), MHD_OPTION_SOCK_ADDR,
      reinterpret_cast<const sockaddr*>(&address), MHD_OPTION_CONNECTION_LIMIT, kConnections,
      MHD_OPTION_PER_IP_CONNECTION_LIMIT, options.behind_proxy ? kConnections : kPerAddress,
      MHD_OPTION_CONNECTION_TIMEOUT, static_cast<unsigned>(kIdleSeconds), MHD_OPTION_NOTIFY_COMPLETED,
      &State::on_completed, state.get(), MHD_OPTION_NOTIFY_CONNECTION, &State::on_connection, state.get(),
      MHD_OPTION_STRICT_FOR_CLIENT, 1, MHD_OPTION_ARRAY, tls ? secure.data() : &plain, MHD_OPTION_END);
  if (!state->daemon)
    return fail(Code::kIo,
                options.address + ":" + std::to_string(options.port) + ": " +
                    (errno != 0 ? std::strerror(errno) : "cannot listen") +
                    (tls ? "; are certificate and key right?" : "; choose another port with --port"));
  return HttpServer(std::move(state));
}

std::uint16_t HttpServer::port() const {
  return MHD_get_daemon_info(state_->daemon, MHD_DAEMON_INFO_BIND_PORT)->port;
}

int HttpServer::descriptor() const {
  return MHD_get_daemon_info(state_->daemon, MHD_DAEMON_INFO_EPOLL_FD)->epoll_fd;
}

int HttpServer::patience_ms() const {
  if (state_->news) return 0;
  constexpr int kLook = 1000;
  MHD_UNSIGNED_LONG_LONG due = 0;
  if (MHD_get_timeout(state_->daemon, &due) == MHD_YES && due < kLook) return static_cast<int>(due);
  return state_->connections.empty() ? -1 : kLook;
}

void HttpServer::turn() {
  state_->close_slow();
  if (!state_->streams.empty() && Clock::now() - state_->beat >= kBeat) {
    state_->beat = Clock::now();
    state_->ring.beat();
    state_->news = true;
  }
  if (state_->news) state_->wake();
  MHD_run(state_->daemon);
  // Those that came together had something to be read when they came.
  state_->keep_strangers(kStrangers);
}

void HttpServer::tell(const std::string& event, const std::string& json) {
  state_->ring.add(event, json);
  state_->news = true;
}

void HttpServer::finish(std::uint64_t ticket, const Reply& reply) { state_->finish(ticket, reply); }

std::size_t HttpServer::listeners() const { return state_->streams.size(); }

}  // namespace tiltfeed::desk
