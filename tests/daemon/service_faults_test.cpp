// What the service meets in a shop: clients that send much at once, files that are saved meanwhile, a table
// that is lost, memory that runs out.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pthread.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <thread>

#include "daemon/service/api_socket.h"
#include "daemon/service/planner.h"
#include "daemon/service/spool.h"
#include "daemon/service/spool_backup.h"
#include "tests/peers/spool_add.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

TEST(ApiSocket, ManyLinesAtOnceAreTakenOneAfterTheOther) {
  const Folder folder("parts");
  const std::string path = folder.path + "/api.sock";
  auto socket = ApiSocket::open(path);
  ASSERT_TRUE(socket) << socket.error().message;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path.c_str());
  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  const std::string lines(100, '\n');
  ASSERT_EQ(::send(fd, lines.data(), lines.size(), 0), 100);
  int depth = 0, deepest = 0;
  std::size_t answered = 0;
  const ApiTaker take = [&](Asked asked) {
    deepest = std::max(deepest, ++depth);
    socket->reply(asked.client, "a", take);
    --depth;
  };
  char reply[200];
  while (answered < 100) {
    std::vector<pollfd> polled;
    socket->add_to(polled);
    ::poll(polled.data(), polled.size(), 5);
    socket->serve(polled, take);
    if (const ssize_t size = ::recv(fd, reply, sizeof reply, MSG_DONTWAIT); size > 0)
      answered += static_cast<std::size_t>(size);
  }
  EXPECT_EQ(deepest, 1) << "a line is taken within the one before: a full stack ends the service";
  ::close(fd);
}

/// A socket that lets in so many and never answers.
struct HungService {
  Folder folder{"parts"};
  std::string path = folder.path + "/api.sock";
  sockaddr_un address{};
  int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  explicit HungService(int waiting) {
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path.c_str());
    EXPECT_EQ(::bind(fd, as_address(), sizeof address), 0);
    EXPECT_EQ(::listen(fd, waiting), 0);
  }
  HungService(const HungService&) = delete;
  HungService& operator=(const HungService&) = delete;
  ~HungService() { ::close(fd); }
  const sockaddr* as_address() const { return reinterpret_cast<const sockaddr*>(&address); }
};

TEST(ApiSocket, AServiceThatHangsKeepsNobodyForLong) {
  const HungService service(0);
  // The first is let in and gets no answer, the next cannot even connect.
  std::vector<int> in;
  for (int i = 0; i < 2; ++i) {
    const auto answer = ask_service(service.path, "{}\n", {}, std::chrono::seconds(1));
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().code, Code::kLink) << answer.error().message;
    in.push_back(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0));
    static_cast<void>(::connect(in.back(), service.as_address(), sizeof service.address));
  }
  for (const int fd : in) ::close(fd);
}

/// After Ctrl-C, or in the foreground again, nobody says that the patience is over.
TEST(ApiSocket, AnInterruptIsNotASilentService) {
  const HungService service(8);
  struct sigaction heard {
  }, before{};
  heard.sa_handler = [](int) {};
  ::sigaction(SIGUSR1, &heard, &before);
  const pthread_t asks = ::pthread_self();
  std::atomic<bool> over{false};
  std::thread interrupts([&] {
    while (!over) ::pthread_kill(asks, SIGUSR1), ::usleep(10'000);
  });
  const auto answer = ask_service(service.path, "{}\n", {}, std::chrono::seconds(300));
  over = true;
  interrupts.join();
  ::sigaction(SIGUSR1, &before, nullptr);
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message.find("interrupted"), std::string::npos) << answer.error().message;
  EXPECT_EQ(answer.error().message.find("within"), std::string::npos) << answer.error().message;
}

TEST(Spool, IsFoundBehindALink) {
  const Folder folder("parts");
  std::filesystem::create_directory(folder.path + "/disk");
  std::filesystem::create_directory_symlink("disk", folder.path + "/link");
  const std::string spool = folder.path + "/link/spool";
  const auto opened = Spool::open(spool);
  ASSERT_TRUE(opened) << opened.error().message;
  const auto copied = back_up(spool, folder.path + "/link/copy");
  ASSERT_TRUE(copied) << copied.error().message;
  EXPECT_EQ(back_up(spool, folder.path + "/disk/spool/copy").error().code, Code::kUsage) << "lost with it";
  EXPECT_EQ(back_up(spool, "").error().code, Code::kUsage);
}

TEST(Spool, WithoutItsTableItIsRefusedAndKeepsItsFiles) {
  const Folder folder("parts");
  const std::string spool = folder.path + "/spool";
  {
    auto opened = Spool::open(spool);
    ASSERT_TRUE(opened);
    SpooledJob job;
    job.program = true;
    const int fd = ::open(folder.write("x.nc", "G0X0\n").c_str(), O_RDONLY);
    ASSERT_EQ(*add_job(*opened, job, {fd}), 1u);
    ::close(fd);
  }
  for (const char* const name : {"jobs.db", "jobs.db-wal", "jobs.db-shm"})
    std::filesystem::remove(spool + "/" + name);
  for (int i = 0; i < 2; ++i) {
    const auto opened = Spool::open(spool);
    ASSERT_FALSE(opened) << "its jobs are forgotten, and the next of their number takes their files away";
    EXPECT_NE(opened.error().message.find("the table was lost"), std::string::npos) << opened.error().message;
  }
  EXPECT_EQ(file_text(spool + "/jobs/1/program.nc"), "G0X0\n");
  std::filesystem::rename(spool + "/jobs", folder.path + "/away");
  EXPECT_TRUE(Spool::open(spool));
}

TEST(Planner, WhereMemoryRunsOutItsProcessGoesFirst) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::pause();
    ::_exit(0);
  }
  give_up_first(child);
  EXPECT_EQ(file_text("/proc/" + std::to_string(child) + "/oom_score_adj"), "1000\n");
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

TEST(Spool, AFileThatIsWrittenMeanwhileIsTakenAsItWasOrNotAtAll) {
  const Folder folder("parts");
  auto spool = Spool::open(folder.path + "/spool");
  ASSERT_TRUE(spool);
  const std::string piece(4096, 'A');
  constexpr int kPieces = 256;
  std::string text;
  for (int i = 0; i < kPieces; ++i) text += piece;
  const int fd = ::open(folder.write("saved.nc", text).c_str(), O_RDWR);
  ASSERT_GE(fd, 0);
  std::atomic<bool> enough{false};
  // Somebody saves it again and again, in place: all of one letter, then all of the next.
  std::thread writer([&] {
    for (char letter = 'B'; !enough; letter = letter == 'Z' ? 'A' : static_cast<char>(letter + 1)) {
      const std::string part(piece.size(), letter);
      for (int i = 0; i < kPieces && !enough; ++i) {
        EXPECT_EQ(::pwrite(fd, part.data(), part.size(), static_cast<off_t>(i) * 4096), 4096);
        if (i % 64 == 63) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(letter % 3 * 50));
    }
  });
  SpooledJob job;
  job.program = true;
  int whole = 0, refused = 0;
  while (whole < 3 || refused < 3) {
    const auto taken = add_job(*spool, job, {fd});
    if (!taken) {
      EXPECT_EQ(taken.error().code, Code::kInput) << taken.error().message;
      EXPECT_NE(taken.error().message.find("changes while it is read"), std::string::npos);
      ++refused;
      continue;
    }
    const std::string copy = file_text(spool->file(*taken, "program.nc"));
    EXPECT_TRUE(copy == std::string(text.size(), copy.empty() ? '?' : copy[0]))
        << "a part of two savings each";
    ++whole;
    if (testing::Test::HasFailure()) break;
  }
  enough = true;
  writer.join();
  ::close(fd);
}

}  // namespace
}  // namespace tiltfeed
