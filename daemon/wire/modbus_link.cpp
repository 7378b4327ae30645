#include "daemon/wire/modbus_link.h"

#include <fcntl.h>
#include <modbus/modbus.h>
#include <netdb.h>
#include <sys/file.h>
#include <sys/select.h>

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "daemon/wire/modbus_map.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;

/// Two lost TCP replies must fit into the controller's 1 s heartbeat limit.
constexpr Time kTcpReplyTimeout = milliseconds(300);
/// A drive's move is not repeated, so that an answer that is only late must not end the run.
constexpr Time kDriveReplyTimeout = milliseconds(1000);
/// What an RTU controller may think about, beside the time that the bytes take.
constexpr Time kRtuThinkTime = milliseconds(100);
/// Bytes of the longest request and reply (FC23: 118 words out, 24 in; FC3: 125 words), 11 bits a byte (8E1).
constexpr int kLongestExchange = 256 + 256, kBitsPerByte = 11;
/// Silence between RTU frames: 3.5 characters, 1.75 ms above 19200 baud (Modbus over serial line
/// V1.02, 2.5.1.1).
constexpr Time kLeastSilence = std::chrono::microseconds(1750);
constexpr int kFastBaud = 19200;
/// Between attempts to connect again.
constexpr Time kReconnectPause = milliseconds(200);
/// libmodbus puts the descriptor into an fd_set.
constexpr int kMaxDescriptor = FD_SETSIZE;

struct FreeContext {
  void operator()(modbus_t* context) const {
    modbus_close(context);
    modbus_free(context);
  }
};
using Context = std::unique_ptr<modbus_t, FreeContext>;

Time silence(const LinkSpec& link) {
  if (!is_rtu(link.kind)) return Time::zero();
  if (link.baud > kFastBaud) return kLeastSilence;
  return time_of(3.5 * kBitsPerByte / link.baud);
}

/// libmodbus leaves the errno of whatever it called last: an unknown name as a refused connection, a
/// connection that was not made in time as one in progress.
std::string connect_reason(const LinkSpec& link, int reason) {
  if (is_rtu(link.kind)) return modbus_strerror(reason);
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  if (const int wrong = ::getaddrinfo(link.place.c_str(), nullptr, &hints, &found); wrong != 0)
    return std::string(::gai_strerror(wrong)) + "; check the name";
  ::freeaddrinfo(found);
  if (reason == EINPROGRESS || reason == ETIMEDOUT || reason == EAGAIN)
    return "no answer in " + std::to_string(kTcpReplyTimeout.count() / 1'000'000) +
           " ms; check the address, the cable and the power";
  return modbus_strerror(reason);
}

class ModbusLink : public Link {
 public:
  ModbusLink(LinkSpec spec, Context context, Time reply_timeout)
      : spec_(std::move(spec)), context_(std::move(context)), reply_timeout_(reply_timeout) {}

  /// Errors: kLink with the reason.
  Result<void> connect() {
    if (modbus_connect(context_.get()) != 0)
      return fail(Code::kLink, describe(spec_) + ": cannot connect: " + connect_reason(spec_, errno));
    const int fd = modbus_get_socket(context_.get());
    if (fd >= kMaxDescriptor) {
      modbus_close(context_.get());
      return fail(Code::kLink,
                  describe(spec_) + ": descriptor " + std::to_string(fd) +
                      " is beyond 1023, which libmodbus cannot use; close files or lower ulimit -n");
    }
    ::fcntl(fd, F_SETFD, FD_CLOEXEC);
    if (is_rtu(spec_.kind) && ::flock(fd, LOCK_EX | LOCK_NB) != 0) {
      modbus_close(context_.get());
      return fail(Code::kLink, describe(spec_) + ": another program has the port");
    }
    connected_ = true;
    return {};
  }

  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    if (out.empty()) {
      std::this_thread::sleep_for(wait);
      return 0;
    }
    in += pack_reply(ask(unpack_request(out)));
    return out.size();
  }

 private:
  ModbusReply ask(const ModbusRequest& request) {
    ModbusReply reply;
    if (!connected_ && !connect()) {
      std::this_thread::sleep_for(kReconnectPause);
      return reply;
    }
    std::this_thread::sleep_until(next_frame_);
    ask_connected(request, reply);
    next_frame_ = std::chrono::steady_clock::now() + silence_;
    return reply;
  }

  void ask_connected(const ModbusRequest& request, ModbusReply& reply) {
    reply.words.resize(request.read_count);
    const int writes = static_cast<int>(request.words.size()), reads = request.read_count;
    int done = 0;
    if (writes > 0 && reads > 0) {
      done =
          modbus_write_and_read_registers(context_.get(), request.write_address, writes, request.words.data(),
                                          request.read_address, reads, reply.words.data());
    } else if (writes > 0) {
      done = modbus_write_registers(context_.get(), request.write_address, writes, request.words.data());
    } else {
      done = modbus_read_registers(context_.get(), request.read_address, reads, reply.words.data());
    }
    if (done == (reads > 0 ? reads : writes)) {
      reply.outcome = kReplyOk;
      return;
    }
    reply.words.clear();
    const int exception = errno - MODBUS_ENOBASE;
    if (done < 0 && exception >= MODBUS_EXCEPTION_ILLEGAL_FUNCTION && exception < MODBUS_EXCEPTION_MAX) {
      reply.outcome = static_cast<std::uint8_t>(exception);
      return;
    }
    clean_wire();
  }

  void clean_wire() {
    if (!is_rtu(spec_.kind)) {
      modbus_close(context_.get());
      connected_ = false;
      return;
    }
    std::this_thread::sleep_for(reply_timeout_);  // a late reply comes now or never
    modbus_flush(context_.get());
  }

  LinkSpec spec_;
  Context context_;
  Time reply_timeout_, silence_ = daemon::silence(spec_);
  std::chrono::steady_clock::time_point next_frame_{};  // not before, on a serial line
  bool connected_ = false;
};

Result<Context> make_context(const LinkSpec& link) {
  if (!is_rtu(link.kind)) {
    Context context(modbus_new_tcp_pi(link.place.c_str(), std::to_string(link.port).c_str()));
    if (!context) return fail(Code::kLink, describe(link) + ": " + modbus_strerror(errno));
    return context;
  }
  const std::unique_ptr<char, decltype(&std::free)> device(::realpath(link.place.c_str(), nullptr),
                                                           &std::free);
  if (!device)
    return fail(Code::kLink, describe(link) + ": cannot be opened: " + std::strerror(errno) +
                                 "; check the name and your group (dialout)");
  Context context(modbus_new_rtu(device.get(), link.baud, 'E', 8, 1));
  if (!context) return fail(Code::kLink, describe(link) + ": " + modbus_strerror(errno));
  return context;
}

}  // namespace

Result<std::unique_ptr<Link>> open_modbus_link(const LinkSpec& link) {
  Result<Context> context = make_context(link);
  if (!context) return tl::unexpected<Error>(context.error());
  Time timeout = is_drive(link.kind) ? kDriveReplyTimeout : kTcpReplyTimeout;
  if (is_rtu(link.kind))
    timeout =
        (is_drive(link.kind) ? kDriveReplyTimeout : kRtuThinkTime) +
        std::chrono::duration_cast<Time>(std::chrono::seconds(kLongestExchange * kBitsPerByte)) / link.baud;
  const auto microseconds = std::chrono::duration_cast<std::chrono::microseconds>(timeout).count();
  modbus_set_error_recovery(context->get(), MODBUS_ERROR_RECOVERY_NONE);
  modbus_set_response_timeout(context->get(), static_cast<std::uint32_t>(microseconds / 1000000),
                              static_cast<std::uint32_t>(microseconds % 1000000));
  modbus_set_byte_timeout(context->get(), static_cast<std::uint32_t>(microseconds / 1000000),
                          static_cast<std::uint32_t>(microseconds % 1000000));
  if (modbus_set_slave(context->get(), link.unit) != 0)
    return fail(Code::kLink, describe(link) + ": unit " + std::to_string(link.unit) + " is not possible");
  auto opened = std::make_unique<ModbusLink>(link, std::move(*context), timeout);
  if (const Result<void> connected = opened->connect(); !connected)
    return tl::unexpected<Error>(connected.error());
  return opened;
}

}  // namespace tiltfeed::daemon
