// A status line whose reader takes nothing for a while.

#include "daemon/command/patient_writer.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <string>
#include <thread>

namespace tiltfeed {
using namespace daemon;
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;

/// A pipe that takes nothing more and does not block whoever writes.
struct FullPipe {
  FullPipe() {
    EXPECT_EQ(::pipe2(ends, O_NONBLOCK), 0);
    while (::write(ends[1], "....", 4) > 0) continue;
  }
  ~FullPipe() {
    if (ends[0] >= 0) ::close(ends[0]);
    // The writer's thread may still have the other one.
  }
  std::string read_all() const {
    std::string text(65536, 0);
    const ssize_t count = ::read(ends[0], text.data(), text.size());
    text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return text;
  }
  int ends[2]{-1, -1};
};

TEST(PatientWriter, ADescriptorThatDoesNotBlockIsWaitedFor) {
  FullPipe pipe;
  PatientWriter writer(pipe.ends[1]);
  writer.write("late\n", false);
  std::this_thread::sleep_for(milliseconds(300));
  EXPECT_FALSE(writer.failed());
  std::string text;
  for (const auto end = steady_clock::now() + seconds(20); steady_clock::now() < end;) {
    text += pipe.read_all();
    if (text.ends_with("late\n")) break;
    std::this_thread::sleep_for(milliseconds(5));
  }
  EXPECT_TRUE(text.ends_with("late\n"));
  EXPECT_FALSE(writer.failed());
}

TEST(PatientWriter, OfManyLinesTheNewestLeave) {
  FullPipe pipe;
  PatientWriter writer(pipe.ends[1]);
  for (int i = 0; i < 1000; ++i) writer.write(std::to_string(i) + "\n", false);
  std::string text;
  for (const auto end = steady_clock::now() + seconds(20); steady_clock::now() < end;) {
    text += pipe.read_all();
    if (text.ends_with("\n999\n")) break;
    std::this_thread::sleep_for(milliseconds(5));
  }
  EXPECT_TRUE(text.ends_with("\n998\n999\n"))
      << text.substr(text.size() - std::min<std::size_t>(text.size(), 60));
}

TEST(PatientWriter, NothingLeavesForAFileThatHasItsNumberLater) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const std::string much(1 << 20, '.');  // more than a pipe takes
  {
    PatientWriter writer(ends[1]);
    writer.write(much, false);
    writer.write("late\n", false);
  }
  std::FILE* other = std::tmpfile();
  ASSERT_NE(other, nullptr);
  ASSERT_EQ(::dup2(::fileno(other), ends[1]), ends[1]);
  std::string text(65536, 0);
  std::size_t taken = 0;
  ssize_t count = 0;
  while ((count = ::read(ends[0], text.data(), text.size())) > 0) taken += static_cast<std::size_t>(count);
  EXPECT_EQ(count, 0);  // the writer's thread has let go
  EXPECT_EQ(taken, much.size());
  EXPECT_EQ(::lseek(ends[1], 0, SEEK_END), 0);
  ::close(ends[0]), ::close(ends[1]), std::fclose(other);
}

TEST(PatientWriter, ItsEndIsNotHeldUpByAFullPipe) {
  FullPipe pipe;
  const auto began = steady_clock::now();
  { PatientWriter(pipe.ends[1]).write("never\n", false); }
  EXPECT_LT(steady_clock::now() - began, seconds(20));
}

TEST(PatientWriter, NobodyWhoReadsIsTold) {
  std::signal(SIGPIPE, SIG_IGN);
  FullPipe pipe;
  PatientWriter writer(pipe.ends[1]);
  writer.write("never\n", false);
  ::close(pipe.ends[0]);
  pipe.ends[0] = -1;
  for (const auto end = steady_clock::now() + seconds(20); !writer.failed() && steady_clock::now() < end;)
    std::this_thread::sleep_for(milliseconds(5));
  EXPECT_TRUE(writer.failed());
}

}  // namespace
}  // namespace tiltfeed
