// The memory of the process that streams does not grow with the program: the service's own thread, with
// journal, black box and machine time, sends a hundred thousand blocks and then a million over a real wire,
// to a simulated machine in another process.

#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

#include "daemon/service/stream_thread.h"
#include "sim/wire/endpoint.h"
#include "tests/shapes/wide_machine.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

/// What the product promises for a program of 10 million blocks, MB; and what a tenth of that may add to what
/// a hundredth takes: machine time at every 64th block is 125 kB, the allocator's growth steps are the rest.
constexpr double kMostMegabytes = 32.0, kMostGrowth = 1.0;

double peak_megabytes() {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) * 1024.0 / 1e6;
  return 0.0;
}

/// A simulated machine in a process of its own; where() once it listens.
class MachineProcess {
 public:
  explicit MachineProcess(const std::function<void(sim::EndpointOptions)>& serve) {
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    pid_ = ::fork();
    if (pid_ == 0) {
      sim::EndpointOptions options;
      options.ready = [&](const std::string& where) {
        if (::write(ends[1], where.data(), where.size()) < 0) ::_exit(1);
        ::close(ends[1]);
      };
      serve(options);
      ::_exit(0);
    }
    ::close(ends[1]);
    char text[200];
    for (ssize_t size; (size = ::read(ends[0], text, sizeof text)) > 0;)
      where_.append(text, static_cast<std::size_t>(size));
    ::close(ends[0]);
  }
  ~MachineProcess() {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  MachineProcess(const MachineProcess&) = delete;
  MachineProcess& operator=(const MachineProcess&) = delete;
  const std::string& where() const { return where_; }

 private:
  pid_t pid_ = 0;
  std::string where_;
};

class Memory : public testing::Test {
 protected:
  /// Peak of this process after the service has streamed so many blocks, MB.
  double after(int blocks, const std::string& link) {
    const std::string path = folder.path + "/program.nc";
    {
      std::ofstream out(path);
      out << "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG93\n";
      for (int i = 0; i < blocks; ++i) out << "G1X" << i % 997 << "." << i % 10 << "F60000\n";
      out << "G94\nM2\n";
    }
    const auto spec = parse_link(link);
    EXPECT_TRUE(spec) << spec.error().message;
    const auto run = prepare_run(path, *spec, 1);
    EXPECT_TRUE(run) << run.error().message;
    ResumeDecision fresh;
    fresh.way = ResumeWay::kFresh;
    std::filesystem::remove(folder.path + "/journal");
    StreamThread runner([] {});
    runner.start({.run = *run,
                  .decision = fresh,
                  .journal = folder.path + "/journal",
                  .wire_log = folder.path + "/blackbox.txt",
                  .way_back = {},
                  .machine = wide_machine()});
    std::optional<RunView> end;
    while (!(end = runner.take_end())) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_TRUE(*end->ended) << end->ended->error().message;
    EXPECT_EQ(end->state.executed, run->subject.total);
    return peak_megabytes();
  }

  void expect_flat(const std::string& link) {
    const double hundredth = after(100'000, link), tenth = after(1'000'000, link);
    std::printf("%s: %.1f MB after 100,000 blocks, %.1f MB after 1,000,000\n", link.c_str(), hundredth,
                tenth);
    EXPECT_LE(tenth, kMostMegabytes);
    EXPECT_LE(tenth - hundredth, kMostGrowth);
  }

  const Folder folder{"memory"};
};

TEST_F(Memory, AMillionBlocksOverGrblTakeNoMoreThanAHundredThousand) {
  const std::string place = folder.path + "/machine";
  const MachineProcess machine([&](const sim::EndpointOptions& options) {
    sim::GrblController controller(wide_machine(), {}, {}, [](const sim::TraceRow&) {});
    static_cast<void>(sim::serve_pty(controller, place, options));
  });
  expect_flat("grbl:" + place);
}

TEST_F(Memory, AMillionBlocksOverModbusTakeNoMoreThanAHundredThousand) {
  const MachineProcess machine([](const sim::EndpointOptions& options) {
    sim::ModbusController controller(wide_machine(), {}, {}, [](const sim::TraceRow&) {});
    static_cast<void>(sim::serve_modbus_tcp(controller, "127.0.0.1", 0, options));
  });
  expect_flat("modbus-tcp:" + machine.where());
}

}  // namespace
}  // namespace tiltfeed
