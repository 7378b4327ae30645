// The simulated controllers on real links, seen from a host with plain descriptors and hand-made frames.

#include "sim/wire/endpoint.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <future>
#include <thread>

#include "tests/peers/sim_machine.h"

namespace tiltfeed::sim {
using namespace config;
namespace {

constexpr int kPatienceMs = 200000;  // only a hanging server reaches it

const std::string kBanner = "\r\nGrbl 1.1h ['$' for help]\r\n";

/// Runs one of the serve calls on a thread of its own until the test ends it.
class Served {
 public:
  template <class Serve>
  Served(EndpointOptions options, Serve serve) {
    EXPECT_EQ(pipe(stop_), 0);
    options.stop_fd = stop_[0];
    options.ready = [this](const std::string& where) { where_.set_value(where); };
    thread_ = std::thread([this, options, serve] {
      result_ = serve(options);
      if (!result_) where_.set_value("failed");
      ended_ = true;
    });
    place_ = where_.get_future().get();
  }
  ~Served() {
    stop();
    close(stop_[0]);
    close(stop_[1]);
  }
  void stop() {
    if (!thread_.joinable()) return;
    EXPECT_EQ(write(stop_[1], "x", 1), 1);
    thread_.join();
  }
  const std::string& place() const { return place_; }
  const Result<void>& result() const { return result_; }
  bool ended() const { return ended_; }

 private:
  int stop_[2] = {-1, -1};
  std::thread thread_;
  std::promise<std::string> where_;
  std::string place_;
  Result<void> result_;
  std::atomic<bool> ended_ = false;
};

/// A host's end of a wire.
class Wire {
 public:
  explicit Wire(int fd) : fd_(fd) { EXPECT_GE(fd, 0); }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;
  ~Wire() { close(fd_); }
  void send(const std::string& bytes) {
    EXPECT_EQ(write(fd_, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  /// Exactly n bytes; fewer when the other end closed or nothing came for long.
  std::string receive(std::size_t n) {
    std::string got;
    while (got.size() < n) {
      pollfd wait{fd_, POLLIN, 0};
      char bytes[4096];
      const ssize_t count =
          poll(&wait, 1, kPatienceMs) == 1 ? read(fd_, bytes, std::min(sizeof bytes, n - got.size())) : 0;
      if (count <= 0) break;
      got.append(bytes, static_cast<std::size_t>(count));
    }
    return got;
  }

 private:
  int fd_;
};

std::string temporary(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("sim_endpoint_" + std::to_string(getpid()) + "_" + name))
      .string();
}

int open_tty(const std::string& path) { return open(path.c_str(), O_RDWR | O_NOCTTY); }

TEST(SimPty, ServesAHostThatComesAndGoes) {
  const std::string path = temporary("tty");
  std::atomic<int> rows = 0;
  GrblController controller(test_machine(), {}, {}, [&](const TraceRow&) { ++rows; });
  Served served({}, [&](const EndpointOptions& options) { return serve_pty(controller, path, options); });
  ASSERT_TRUE(std::filesystem::is_symlink(path));
  {
    Wire host(open_tty(path));
    EXPECT_EQ(host.receive(kBanner.size()), kBanner);
    host.send("G0 X1\nG0 X2\nG4 P0\n");
    EXPECT_EQ(host.receive(12), "ok\r\nok\r\nok\r\n");
    EXPECT_EQ(rows, 3) << "the barrier was answered, so all before it was executed";
  }
  {
    Wire host(open_tty(path));
    host.send("\x18");
    EXPECT_EQ(host.receive(kBanner.size()), kBanner) << "no echo, no byte changed";
    std::string text, oks;
    for (int i = 0; i < 60; ++i) text += "G93 G1 X" + std::to_string(i) + " F1000\n", oks += "ok\r\n";
    host.send(text);
    EXPECT_EQ(host.receive(oks.size()), oks);
  }
  served.stop();
  EXPECT_TRUE(served.result());
  EXPECT_FALSE(std::filesystem::exists(std::filesystem::symlink_status(path))) << "its name is gone";
}

TEST(SimPty, LeavesOtherFilesAlone) {
  const std::string path = temporary("file");
  std::ofstream(path) << "precious";
  GrblController controller(test_machine(), {}, {}, [](const TraceRow&) {});
  const auto served = serve_pty(controller, path, {});
  ASSERT_FALSE(served);
  EXPECT_EQ(served.error().code, Code::kIo);
  EXPECT_NE(served.error().message.find(path), std::string::npos);
  std::string text;
  std::ifstream(path) >> text;
  EXPECT_EQ(text, "precious");
  std::filesystem::remove(path);
}

TEST(SimPty, ReplacesADeadLink) {
  const std::string path = temporary("stale");
  std::filesystem::create_symlink("/dev/pts/no-such-terminal", path);
  GrblController controller(test_machine(), {}, {}, [](const TraceRow&) {});
  Served served({}, [&](const EndpointOptions& options) { return serve_pty(controller, path, options); });
  Wire host(open_tty(path));
  EXPECT_EQ(host.receive(4).substr(0, 4), "\r\nGr");
}

TEST(SimPty, PacedTimeTakesItsTime) {
  const std::string path = temporary("paced");
  GrblController controller(test_machine(), {}, {}, [](const TraceRow&) {});
  Served served({.speed = 10},
                [&](const EndpointOptions& options) { return serve_pty(controller, path, options); });
  Wire host(open_tty(path));
  host.receive(kBanner.size());
  const auto begin = std::chrono::steady_clock::now();
  host.send("G93 G1 X1 F30\nG4 P0\n");  // 2 s at ten times the speed
  EXPECT_EQ(host.receive(8), "ok\r\nok\r\n");
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_GE(seconds, 0.19);
}

TEST(SimPty, OnceLeavesAfterTheProgram) {
  const std::string path = temporary("once");
  GrblController controller(test_machine(), {}, {}, [](const TraceRow&) {});
  Served served({.once = true},
                [&](const EndpointOptions& options) { return serve_pty(controller, path, options); });
  Wire host(open_tty(path));
  host.receive(kBanner.size());
  host.send("G0 X1\nM2\n");
  EXPECT_EQ(host.receive(8), "ok\r\nok\r\n");
  for (int i = 0; i < 10000 && !served.ended(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_TRUE(served.ended());
}

// --- Modbus TCP ---

std::string be16(int value) { return {static_cast<char>(value >> 8), static_cast<char>(value & 0xFF)}; }

std::string frame(int transaction, const std::string& pdu) {
  return be16(transaction) + be16(0) + be16(static_cast<int>(pdu.size()) + 1) + '\x01' + pdu;
}

std::string words(const std::vector<std::uint16_t>& values) {
  std::string text;
  for (const std::uint16_t value : values) text += be16(value);
  return text;
}

class SimTcp : public ::testing::Test {
 protected:
  SimTcp()
      : controller(test_machine(), {}, {.ring = 16, .boot_id = 3}, [](const TraceRow&) {}),
        served({}, [this](const EndpointOptions& options) {
          return serve_modbus_tcp(controller, "127.0.0.1", 0, options);
        }) {}
  int connected() const {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(served.place().substr(10))));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return fd;
  }
  /// The reply's PDU.
  static std::string ask(Wire& host, const std::string& pdu) {
    static int transaction = 100;
    ++transaction;
    host.send(frame(transaction, pdu));
    const std::string header = host.receive(7);
    if (header.size() < 7) return "closed";
    EXPECT_EQ(header.substr(0, 2), be16(transaction));
    return host.receive(static_cast<std::size_t>(static_cast<unsigned char>(header[5])) - 1);
  }
  ModbusController controller;
  Served served;
};

const std::string kReadIdentity = "\x03" + be16(0) + be16(3);
const std::string kIdentity = "\x03\x06" + words({0x5446, 1, 15});

TEST_F(SimTcp, ServesClientsOneAfterTheOther) {
  for (int i = 0; i < 3; ++i) {
    Wire host(connected());
    EXPECT_EQ(ask(host, kReadIdentity), kIdentity);
  }
  EXPECT_EQ(served.place().substr(0, 10), "127.0.0.1:");
}

TEST_F(SimTcp, WritesThenReadsInOneRequest) {
  Wire host(connected());
  std::vector<std::uint16_t> open{9, 1, 1, 0, 0};
  const std::uint32_t crc = crc_of_words(open);
  open.push_back(static_cast<std::uint16_t>(crc >> 16));
  open.push_back(static_cast<std::uint16_t>(crc));
  const std::string reply =
      ask(host, "\x17" + be16(0x0200) + be16(4) + be16(0x0180) + be16(7) + '\x0e' + words(open));
  EXPECT_EQ(reply, "\x17\x08" + words({1, 3, 9, 0})) << "the status already shows the session";
  EXPECT_EQ(ask(host, "\x06" + be16(0x0240) + be16(77)), "\x06" + be16(0x0240) + be16(77));
  EXPECT_EQ(ask(host, "\x03" + be16(0x020E) + be16(1)), "\x03\x02" + be16(77));
  EXPECT_EQ(ask(host, "\x10" + be16(0x0240) + be16(1) + '\x02' + be16(78)), "\x10" + be16(0x0240) + be16(1));
}

TEST_F(SimTcp, AnswersExceptions) {
  Wire host(connected());
  EXPECT_EQ(ask(host, "\x03" + be16(0x0100) + be16(1)), "\x83\x02");
  EXPECT_EQ(ask(host, "\x03" + be16(0) + be16(126)), "\x83\x03");
  EXPECT_EQ(ask(host, "\x03" + be16(0) + be16(0)), "\x83\x03");
  EXPECT_EQ(ask(host, "\x06" + be16(0) + be16(0)), "\x86\x02");
  EXPECT_EQ(ask(host, "\x10" + be16(0x0100) + be16(1) + '\x02' + be16(0)), "\x90\x03");
  EXPECT_EQ(ask(host, "\x10" + be16(0x0240) + be16(2) + '\x02' + be16(0)), "\x90\x03") << "counts disagree";
  EXPECT_EQ(ask(host, "\x10" + be16(0x0240) + be16(1) + '\x04' + be16(7) + be16(7)), "\x90\x03");
  EXPECT_EQ(ask(host, "\x01" + be16(0) + be16(1)), "\x81\x01");
  EXPECT_EQ(ask(host, "\x17" + be16(0x0300) + be16(1) + be16(0x0240) + be16(1) + '\x02' + be16(55)),
            "\x97\x02");
  EXPECT_EQ(ask(host, "\x03" + be16(0x020E) + be16(1)), "\x03\x02" + be16(0)) << "and nothing was written";
}

TEST_F(SimTcp, SurvivesNonsense) {
  for (const std::string& bytes : {std::string("\x00\x01", 2), std::string(300, '\xff'),
                                   std::string("GET / HTTP/1.1\r\nHost: machine\r\n\r\n"),
                                   frame(1, "\x10" + be16(0x0100) + be16(118))}) {
    Wire host(connected());
    host.send(bytes);
    host.receive(1);
  }
  Wire host(connected());
  EXPECT_EQ(ask(host, kReadIdentity), kIdentity);
}

TEST(SimModbus, NamesWrongAddresses) {
  ModbusController controller(test_machine(), {}, {}, [](const TraceRow&) {});
  const auto name = serve_modbus_tcp(controller, "machine.local", 1502, {});
  ASSERT_FALSE(name);
  EXPECT_EQ(name.error().code, Code::kUsage);
  EXPECT_FALSE(serve_modbus_tcp(controller, "127.0.0.1", 70000, {}));
}

}  // namespace
}  // namespace tiltfeed::sim
