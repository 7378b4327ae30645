// The register-map model behind libmodbus, which does the framing: TCP and RTU.

#include <arpa/inet.h>
#include <modbus/modbus.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <memory>
#include <thread>

#include "sim/wire/endpoint.h"
#include "sim/wire/faulty_line.h"
#include "sim/wire/pty.h"

namespace tiltfeed::sim {
namespace {

constexpr int kRtuUnit = 1;
constexpr int kMostWriteWords = 123;      // FC 16
constexpr int kMostReadWriteWords = 121;  // FC 23, its write part
constexpr int kMostReadWords = 125;
constexpr std::uint8_t kReadHolding = 3, kWriteSingle = 6, kWriteMultiple = 16, kReadWrite = 23;

struct FreeContext {
  void operator()(modbus_t* context) const { modbus_free(context); }
};
struct FreeMapping {
  void operator()(modbus_mapping_t* mapping) const { modbus_mapping_free(mapping); }
};
using Context = std::unique_ptr<modbus_t, FreeContext>;
using Mapping = std::unique_ptr<modbus_mapping_t, FreeMapping>;

/// One request's function code and data, inside the frame that libmodbus received.
struct Request {
  const std::uint8_t* bytes;
  std::size_t size;
  std::uint8_t function() const { return size > 0 ? bytes[0] : 0; }
  /// The 16-bit number at byte `at`. Requires: at + 2 <= size.
  std::uint16_t word(std::size_t at) const {
    return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
  }
};

int exception_of(Access access) {
  return access == Access::kIllegalAddress ? MODBUS_EXCEPTION_ILLEGAL_DATA_ADDRESS
         : access == Access::kIllegalValue ? MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE
                                           : 0;
}

/// Applies requests to the model; libmodbus then only encodes the reply from `mapping`.
class Server {
 public:
  Server(ModbusController& controller, modbus_t* context, const EndpointOptions& options)
      : controller_(controller),
        context_(context),
        line_(options.faults),
        byte_time_(options.byte_time),
        mapping_(modbus_mapping_new(0, 0, kMapEnd, 0)) {}
  bool good() const { return mapping_ != nullptr; }

  /// Receives and answers one request. False when the client has gone or talks nonsense.
  bool serve() {
    std::array<std::uint8_t, MODBUS_MAX_ADU_LENGTH> frame{};
    const int length = modbus_receive(context_, frame.data());
    if (length < 0) return false;
    if (length == 0) return true;  // RTU: for another unit
    const int header = modbus_get_header_length(context_);
    const Request request{frame.data() + header, static_cast<std::size_t>(length - header)};
    const FrameFate fate = line_.frame();
    const auto heard = std::chrono::steady_clock::now();
    // A frame that follows without silence is part of the one before, for a slave that listens.
    if (heard < quiet_until_) return true;
    busy_until_ = heard;
    pass(length, silence());
    if (fate.lose_request) return true;
    const int exception = fate.exception != 0 ? fate.exception : apply(request);
    if (fate.lose_reply) return true;
    if (fate.wrong_unit) frame[static_cast<std::size_t>(header - 1)] ^= 8;
    if (fate.half_frame) return write_raw(frame.data(), static_cast<std::size_t>(header + 1));
    pass(exception != 0 ? kShortReply : reply_bytes(request), fate.late);
    quiet_until_ = std::chrono::steady_clock::now() + to_duration(silence());
    const int sent = exception != 0
                         ? modbus_reply_exception(context_, frame.data(), static_cast<unsigned>(exception))
                         : modbus_reply(context_, frame.data(), length, mapping_.get());
    return sent >= 0;
  }

  /// The rules of the fault script that have a time. True when the client must go.
  bool follow_faults(double now) {
    if (line_.reset_due(now)) controller_.reset();
    return line_.away(now);
  }

 private:
  static constexpr int kShortReply = 5;

  static std::chrono::nanoseconds to_duration(double seconds) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds));
  }
  /// That ends a frame on a paced line: 3.5 characters, 1.75 ms above 19200 baud. A slave waits for it before
  /// it answers, a master before its next request.
  double silence() const {
    constexpr double kLeastGap = 0.00175;
    return byte_time_ > 0.0 ? std::max(kLeastGap, 3.5 * byte_time_) : 0.0;
  }
  /// The line is busy for so many bytes more, and for `more` s.
  void pass(int bytes, double more) {
    const double span = more + bytes * byte_time_;
    if (span <= 0.0) return;
    busy_until_ += to_duration(span);
    std::this_thread::sleep_until(busy_until_);
  }
  /// Of an RTU reply, with unit, function and CRC.
  static int reply_bytes(const Request& request) {
    const bool reads = request.function() == kReadHolding || request.function() == kReadWrite;
    return reads ? 5 + 2 * request.word(3) : 8;
  }
  bool write_raw(const std::uint8_t* bytes, std::size_t count) const {
    return ::write(modbus_get_socket(context_), bytes, count) == static_cast<ssize_t>(count);
  }

  /// The exception code of the reply; 0: none.
  int apply(const Request& request) {
    switch (request.function()) {
      case kReadHolding:
        if (request.size < 5) return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
        return read(request.word(1), request.word(3));
      case kWriteSingle:
        if (request.size < 5) return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
        return write(request, request.word(1), 1, 3);
      case kWriteMultiple:
        if (!counted(request, 3, kMostWriteWords)) return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
        return write(request, request.word(1), request.word(3), 6);
      case kReadWrite: {
        if (!counted(request, 7, kMostReadWriteWords)) return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
        const std::uint16_t from = request.word(1), count = request.word(3);
        // The write comes first, but not when the read cannot be answered.
        if (const Access access = ModbusController::readable(from, count); access != Access::kOk)
          return exception_of(access);
        if (const int exception = write(request, request.word(5), request.word(7), 10)) return exception;
        return read(from, count);
      }
      default:
        return MODBUS_EXCEPTION_ILLEGAL_FUNCTION;
    }
  }

  /// Do the word count at `at` and the byte count after it agree with each other and with the frame?
  static bool counted(const Request& request, std::size_t at, int most) {
    if (request.size < at + 3) return false;
    const int count = request.word(at), bytes = request.bytes[at + 2];
    return count >= 1 && count <= most && bytes == 2 * count &&
           request.size >= at + 3 + static_cast<std::size_t>(bytes);
  }

  int write(const Request& request, std::uint16_t address, std::size_t count, std::size_t at) {
    std::array<std::uint16_t, kMostWriteWords> words{};
    for (std::size_t i = 0; i < count; ++i) words[i] = request.word(at + 2 * i);
    return exception_of(controller_.write(address, {words.data(), count}));
  }

  int read(std::uint16_t address, std::size_t count) {
    if (count > kMostReadWords) return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
    std::array<std::uint16_t, kMostReadWords> words{};
    const Access access = controller_.read(address, {words.data(), count});
    if (access != Access::kOk) return exception_of(access);
    std::copy_n(words.begin(), count, mapping_->tab_registers + address);
    return 0;
  }

  ModbusController& controller_;
  modbus_t* context_;
  FaultyLine line_;
  double byte_time_;  ///< s; 0: not paced
  std::chrono::steady_clock::time_point busy_until_, quiet_until_{};
  Mapping mapping_;
};

tl::unexpected<Error> modbus_error(const std::string& what) {
  return fail(Code::kIo, what + ": " + modbus_strerror(errno));
}

/// Serves one wire until stop or once. `listener` accepts TCP clients; -1: the wire `client` is always there.
Result<void> serve(ModbusController& controller, modbus_t* context, int listener, int client,
                   const EndpointOptions& options, const std::string& where) {
  Server server(controller, context, options);
  if (!server.good()) return modbus_error(where);
  options.ready(where);
  SimClock pace(options.speed);
  double last_traffic = 0.0;
  while (true) {
    std::array<pollfd, 2> fds{{{client >= 0 ? client : listener, POLLIN, 0}, {options.stop_fd, POLLIN, 0}}};
    const timespec timeout{0, static_cast<long>(pace.wait(controller) * 1e9)};
    if (ppoll(fds.data(), fds.size(), &timeout, nullptr) < 0 && errno != EINTR) return modbus_error(where);
    if (fds[1].revents != 0) break;

    pace.follow(controller);
    controller.advance_link(pace.real());
    const bool heard = fds[0].revents != 0;
    if (server.follow_faults(pace.real())) {
      if (client >= 0 && listener >= 0) modbus_close(context), client = -1;
      continue;
    }
    if (heard && client < 0) {
      client = modbus_tcp_accept(context, &listener);
      const int on = 1;
      if (client >= 0) setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    } else if (heard) {
      pace.make_room(controller);
      const bool served = server.serve();
      if (!served && listener >= 0) {
        modbus_close(context);
        client = -1;
      } else if (!served) {
        modbus_flush(context);  // RTU: a broken frame gets no answer
      }
    } else {
      pace.jump(controller);
    }
    if (heard || controller.next_event()) last_traffic = pace.real();
    if (pace.time_to_flush()) options.flush();
    const bool gone = listener >= 0 && client < 0;
    if (options.once && controller.program_ended() && (gone || pace.real() - last_traffic >= kQuietEnd))
      break;
  }
  options.flush();
  return {};
}

}  // namespace

Result<void> serve_modbus_tcp(ModbusController& controller, const std::string& address, int port,
                              EndpointOptions options) {
  in_addr numeric{};
  if (inet_pton(AF_INET, address.c_str(), &numeric) != 1)
    return fail(Code::kUsage, "'" + address + "' is not a numeric IPv4 address such as 127.0.0.1");
  if (port < 0 || port > 65535) return fail(Code::kUsage, "port " + std::to_string(port) + ": 0 to 65535");
  const std::string asked = address + ":" + std::to_string(port);
  const Context context(modbus_new_tcp(address.c_str(), port));
  if (!context) return modbus_error(asked);
  const int listener = modbus_tcp_listen(context.get(), 1);
  if (listener < 0) return modbus_error(asked);
  sockaddr_in bound{};
  socklen_t size = sizeof bound;
  getsockname(listener, reinterpret_cast<sockaddr*>(&bound), &size);
  Result<void> served = serve(controller, context.get(), listener, -1, options,
                              address + ":" + std::to_string(ntohs(bound.sin_port)));
  modbus_close(context.get());
  close(listener);
  return served;
}

Result<void> serve_modbus_rtu(ModbusController& controller, const std::string& path,
                              EndpointOptions options) {
  Result<Pty> pty = Pty::open(path);
  if (!pty) return tl::unexpected<Error>(std::move(pty.error()));
  const Context context(modbus_new_rtu(pty->device().c_str(), 115200, 'E', 8, 1));
  if (!context || modbus_set_slave(context.get(), kRtuUnit) != 0 ||
      modbus_set_socket(context.get(), pty->master()) != 0)
    return modbus_error(path);
  return serve(controller, context.get(), -1, pty->master(), options, path + " (" + pty->device() + ")");
}

}  // namespace tiltfeed::sim
