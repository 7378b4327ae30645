// Whole sends over real wires: a pseudo-terminal with a small responder, and the simulated controllers on a
// pseudo-terminal, on Modbus RTU and on Modbus TCP. What the machine executed is compared with the program.

#include "daemon/stream/stream.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <future>
#include <thread>

#include "sim/wire/endpoint.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

using std::chrono::milliseconds;

std::string temp_name(const std::string& what) {
  static std::atomic<int> count{0};
  return "/tmp/tiltfeed_stream_" + std::to_string(::getpid()) + "_" + std::to_string(++count) + what;
}

/// A program of `feeds` G93 blocks as the post writes it; gone when the test ends.
struct ProgramFile {
  explicit ProgramFile(int feeds) : path(temp_name(".nc")) {
    std::ofstream out(path);
    out << "%\n(TILTFEED test)\nG21 G90 G94\nG0 X0.0000 Y0.0000 Z50.0000 A0.0000 C0.0000\nM3 S8000\nG93\n";
    char line[120];
    for (int i = 0; i < feeds; ++i) {
      std::snprintf(line, sizeof line, "G1 X%.4f Y%.4f Z%.4f A%.4f C%.4f F%.2f\n", 40 * std::sin(i * 0.01),
                    40 * std::cos(i * 0.013), 10 + 5 * std::sin(i * 0.1), 20 * std::sin(i * 0.003), i * 0.05,
                    60000.0 + i % 7);
      out << line;
    }
    out << "G94\nM5\nM2\n%\n";
  }
  ~ProgramFile() { std::filesystem::remove(path); }
  std::string path;
};

/// Runs a simulated controller in a thread, until the test ends.
class SimThread {
 public:
  template <class Serve>
  explicit SimThread(Serve serve) {
    EXPECT_EQ(::pipe(stop_), 0);
    std::promise<std::string> where;
    std::future<std::string> known = where.get_future();
    thread_ = std::thread([this, serve, promise = std::move(where)]() mutable {
      sim::EndpointOptions options;
      options.stop_fd = stop_[0];
      options.ready = [&](const std::string& text) { promise.set_value(text); };
      const Result<void> served = serve(options);
      EXPECT_TRUE(served) << served.error().message;
    });
    place = known.get();
  }
  ~SimThread() { stop(); }
  void stop() {
    if (!thread_.joinable()) return;
    EXPECT_EQ(::write(stop_[1], "x", 1), 1);
    thread_.join();
    ::close(stop_[0]);
    ::close(stop_[1]);
  }
  std::string place;

 private:
  int stop_[2] = {-1, -1};
  std::thread thread_;
};

/// Every block of the program was executed once, in order, to the last digit.
void expect_executed(const std::string& path, const std::vector<sim::Block>& executed) {
  std::ifstream in(path);
  const auto program = sim::read_program(in, path, 'A', 'C');
  ASSERT_TRUE(program) << program.error().message;
  ASSERT_EQ(executed.size(), program->size());
  for (std::size_t i = 0; i < executed.size(); ++i) {
    ASSERT_EQ(executed[i].op, (*program)[i].op) << i;
    ASSERT_EQ(executed[i].m_code, (*program)[i].m_code) << i;
    if (executed[i].op == sim::Op::kMCode) continue;
    ASSERT_NEAR(executed[i].target.x, (*program)[i].target.x, 1e-9) << i;
    ASSERT_NEAR(executed[i].target.y, (*program)[i].target.y, 1e-9) << i;
    ASSERT_NEAR(executed[i].target.z, (*program)[i].target.z, 1e-9) << i;
    ASSERT_NEAR(executed[i].target.a, (*program)[i].target.a, 1e-9) << i;
    ASSERT_NEAR(executed[i].target.c, (*program)[i].target.c, 1e-9) << i;
    ASSERT_NEAR(executed[i].feed, (*program)[i].feed, 1e-9) << i;
    ASSERT_EQ(executed[i].inverse_time, (*program)[i].inverse_time) << i;
  }
}

double cpu_seconds() {
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

void show(const char* name, const SendReport& report, double cpu) {
  std::printf("%s: %llu blocks in %.3f s, %.0f blocks/s, %.2f us CPU of the sending thread per block\n", name,
              static_cast<unsigned long long>(report.lines), report.seconds,
              static_cast<double>(report.lines) / report.seconds,
              1e6 * cpu / static_cast<double>(report.lines));
}

/// Answers as Grbl does, as fast as it can; measures what is on its way. No planner.
class Responder {
 public:
  explicit Responder(int buffer) : buffer_(buffer), master_(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)) {
    ::grantpt(master_);
    ::unlockpt(master_);
    device = ::ptsname(master_);
    keep_ = ::open(device.c_str(), O_RDWR | O_NOCTTY);
    termios settings{};
    ::tcgetattr(keep_, &settings);
    ::cfmakeraw(&settings);
    ::tcsetattr(keep_, TCSANOW, &settings);
    thread_ = std::thread([this] { serve(); });
  }
  ~Responder() {
    running_ = false;
    thread_.join();
    ::close(keep_);
    if (master_ >= 0) ::close(master_);
  }
  std::string device;
  std::atomic<std::uint64_t> lines{0};
  std::atomic<std::uint64_t> hang_up_after{~0ull}, error_after{~0ull};

 private:
  void serve() {
    char bytes[65536];
    std::string line, out;
    while (running_) {
      pollfd events{master_, static_cast<short>(POLLIN | (out.empty() ? 0 : POLLOUT)), 0};
      if (::poll(&events, 1, 50) <= 0) continue;
      const ssize_t count = ::read(master_, bytes, sizeof bytes);
      for (ssize_t i = 0; i < count; ++i) {
        if (bytes[i] == '?') {
          out += "<Idle|MPos:0,0,0|Bf:15,128>\r\n";
        } else if (bytes[i] == '\x18') {
          out += "\r\nGrblHAL 1.1f ['$' or '$HELP' for help]\r\n";
          line.clear();
        } else if (bytes[i] == '\n') {
          if (line == "$I") {
            out +=
                "[VER:1.1f:]\r\n[OPT:V,15," + std::to_string(buffer_) + "]\r\n[FIRMWARE:grblHAL]\r\nok\r\n";
          } else {
            out += ++lines > error_after ? "error:33\r\n" : "ok\r\n";
          }
          line.clear();
        } else {
          line += bytes[i];
        }
      }
      const ssize_t sent = ::write(master_, out.data(), out.size());
      if (sent > 0) out.erase(0, static_cast<std::size_t>(sent));
      if (lines >= hang_up_after) {
        ::close(keep_);
        ::close(master_);
        keep_ = ::open("/dev/null", O_RDONLY);
        master_ = -1;
        return;
      }
    }
  }
  int buffer_, master_, keep_ = -1;
  std::atomic<bool> running_{true};
  std::thread thread_;
};

LinkSpec grbl_link(const std::string& device) { return *parse_link("grbl:" + device + "@115200"); }

// (stream.h, properties 2 and 3)
TEST(Stream, AResponderOnAPseudoTerminalGetsEveryLine) {
  for (const int buffer : {128, 1024}) {
    const ProgramFile program(buffer == 128 ? 50000 : 200000);
    Responder responder(buffer);
    const double cpu = cpu_seconds();
    const auto report = send_program(program.path, grbl_link(responder.device), {}, {});
    ASSERT_TRUE(report) << report.error().message;
    show(buffer == 128 ? "pseudo-terminal, 128-byte buffer" : "pseudo-terminal, 1024-byte buffer", *report,
         cpu_seconds() - cpu);
    EXPECT_EQ(responder.lines, report->lines + 1) << "the barrier comes on top";
    EXPECT_EQ(report->executed, report->lines);
    EXPECT_EQ(report->acknowledged, report->lines);
    EXPECT_EQ(report->header, "TILTFEED test");
  }
}

// (stream.h, property 5)
TEST(Stream, AnErrorStopsAndNamesTheLine) {
  const ProgramFile program(1000);
  Responder responder(1024);
  responder.error_after = 500;
  const auto report = send_program(program.path, grbl_link(responder.device), {}, {});
  ASSERT_FALSE(report);
  // Line 501 that was sent is line 503 of the file: % and the header comment are not sent.
  EXPECT_NE(report.error().message.find("error:33' to line 503 'G1X"), std::string::npos)
      << report.error().message;
  EXPECT_NE(report.error().message.find("may have run"), std::string::npos);
}

// (stream.h, property 5)
TEST(Stream, APulledCableIsAnErrorAndNoTimeOut) {
  const ProgramFile program(100000);
  Responder responder(1024);
  responder.hang_up_after = 1000;
  const auto report = send_program(program.path, grbl_link(responder.device), {}, {});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, Code::kLink);
  EXPECT_NE(report.error().message.find("connection lost"), std::string::npos) << report.error().message;
  EXPECT_NE(report.error().message.find("may have run"), std::string::npos);
}

// (session.h, property 5)
TEST(Stream, ProgressIsShownAndCanStop) {
  const ProgramFile program(200000);
  Responder responder(1024);
  int calls = 0;
  const auto began = std::chrono::steady_clock::now();
  const auto report =
      send_program(program.path, grbl_link(responder.device), {}, {[&](const SendState& state) {
                     EXPECT_LE(state.executed, state.acknowledged);
                     EXPECT_LE(state.acknowledged, state.sent);
                     EXPECT_EQ(state.total, 200007u);
                     return ++calls < 2;
                   }});
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("stopped on request"), std::string::npos) << report.error().message;
  // Beside changes of phase and the end, one every tenth of a second.
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  EXPECT_LE(calls, 8 + static_cast<int>(took.count() / 0.1));
}

// (stream.h, property 1)
TEST(Stream, NothingIsSentWhenTheProgramIsWrong) {
  const std::string path = temp_name(".nc");
  std::ofstream(path) << "G21\nG0X0Y0Z0A0C0\nG1X1F100\nG1X!2\n";
  Responder responder(1024);
  const auto report = send_program(path, grbl_link(responder.device), {}, {});
  std::ofstream(path) << "G0X0Y0Z0A0C0\nG2X1I1F100\n";
  const auto modbus = send_program(path, *parse_link("modbus-tcp:127.0.0.1:1/1"), {}, {});
  std::filesystem::remove(path);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, Code::kInput);
  EXPECT_NE(report.error().message.find(path + ":4:"), std::string::npos) << report.error().message;
  EXPECT_EQ(responder.lines, 0u);
  ASSERT_FALSE(modbus);
  EXPECT_EQ(modbus.error().code, Code::kInput) << "the program is checked before the wire is opened";
  EXPECT_NE(modbus.error().message.find(":2: 'G2X1I1F100'"), std::string::npos) << modbus.error().message;
}

// (stream.h, properties 2 and 3)
TEST(Stream, TheSimulatedGrblExecutesTheProgram) {
  const ProgramFile program(5000);
  std::vector<sim::Block> executed;
  sim::GrblController controller(wide_machine(), {}, {},
                                 [&](const sim::TraceRow& row) { executed.push_back(row.command); });
  const std::string path = temp_name(".tty");
  SimThread sim(
      [&](const sim::EndpointOptions& options) { return sim::serve_pty(controller, path, options); });
  const double cpu = cpu_seconds();
  const auto report = send_program(program.path, grbl_link(path), {}, {});
  const double used = cpu_seconds() - cpu;
  sim.stop();
  ASSERT_TRUE(report) << report.error().message;
  show("simulated Grbl", *report, used);
  EXPECT_EQ(controller.dropped_bytes(), 0u);
  // The sender's own G4P0 comes after the program.
  if (!executed.empty() && executed.back().op == sim::Op::kDwell) executed.pop_back();
  expect_executed(program.path, executed);
}

// (stream.h, properties 2 and 3)
TEST(Stream, TheSimulatedRingExecutesTheProgramOverTcp) {
  const ProgramFile program(20000);
  std::vector<sim::Block> executed;
  sim::ModbusController controller(wide_machine(), {}, {},
                                   [&](const sim::TraceRow& row) { executed.push_back(row.command); });
  SimThread sim([&](const sim::EndpointOptions& options) {
    return sim::serve_modbus_tcp(controller, "127.0.0.1", 0, options);
  });
  const double cpu = cpu_seconds();
  const auto report = send_program(program.path, *parse_link("modbus-tcp:" + sim.place), {}, {});
  const double used = cpu_seconds() - cpu;
  sim.stop();
  ASSERT_TRUE(report) << report.error().message;
  show("simulated ring, Modbus TCP", *report, used);
  EXPECT_EQ(report->executed, report->lines);
  EXPECT_EQ(controller.rejected_windows(), 0u);
  expect_executed(program.path, executed);
}

// (stream.h, properties 2 and 3)
TEST(Stream, TheSimulatedRingExecutesTheProgramOverRtu) {
  const ProgramFile program(2000);
  std::vector<sim::Block> executed;
  sim::ModbusController controller(wide_machine(), {}, {},
                                   [&](const sim::TraceRow& row) { executed.push_back(row.command); });
  const std::string path = temp_name(".tty");
  SimThread sim(
      [&](const sim::EndpointOptions& options) { return sim::serve_modbus_rtu(controller, path, options); });
  const auto report = send_program(program.path, *parse_link("modbus-rtu:" + path + "@115200/1"), {}, {});
  sim.stop();
  ASSERT_TRUE(report) << report.error().message;
  show("simulated ring, Modbus RTU on a pseudo-terminal", *report, 0.0);
  EXPECT_EQ(report->resends, 0u);
  expect_executed(program.path, executed);
}

TEST(Stream, WithoutAServerTheErrorSaysWhere) {
  const ProgramFile program(10);
  const auto report = send_program(program.path, *parse_link("modbus-tcp:127.0.0.1:1/1"), {}, {});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, Code::kLink);
  EXPECT_NE(report.error().message.find("modbus-tcp:127.0.0.1:1/1"), std::string::npos);
}

}  // namespace
}  // namespace tiltfeed
