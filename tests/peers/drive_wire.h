#pragma once
// The simulated drive behind a TCP port of its own, or behind a serial line (RTU), served by a thread in real
// time until the end of the test. Frames are read and written here, byte by byte.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <string>
#include <vector>

#include "sim/controller/drive_controller.h"
#include "sim/wire/pty.h"

namespace tiltfeed {
using namespace config;

class DriveWire {
 public:
  DriveWire(sim::DriveController& drive, bool tcp, double speed) : drive_(drive), tcp_(tcp), speed_(speed) {}

  /// Serves until `stop` can be read. `ready` gets where it listens: 127.0.0.1:PORT, or `path`, a
  /// pseudo-terminal.
  template <class Ready>
  void serve(const std::string& path, int stop, const Ready& ready) {
    if (tcp_) {
      listen();
      ready("127.0.0.1:" + std::to_string(port_));
      run(stop);
      ::close(listener_);
      if (client_ >= 0) ::close(client_);
      return;
    }
    const auto pty = sim::Pty::open(path);
    ASSERT_TRUE(pty) << pty.error().message;
    client_ = pty->master();
    ready(path);
    run(stop);
  }

 private:
  using Bytes = std::vector<std::uint8_t>;
  static constexpr std::uint8_t kRead = 3, kWrite = 16;

  void listen() {
    listener_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof where;
    ASSERT_EQ(::bind(listener_, reinterpret_cast<sockaddr*>(&where), sizeof where), 0);
    ASSERT_EQ(::listen(listener_, 4), 0);
    ASSERT_EQ(::getsockname(listener_, reinterpret_cast<sockaddr*>(&where), &size), 0);
    port_ = ntohs(where.sin_port);
  }

  void run(int stop) {
    const auto began = std::chrono::steady_clock::now();
    Bytes heard;
    for (;;) {
      std::array<pollfd, 3> fds{{{stop, POLLIN, 0}, {listener_, POLLIN, 0}, {client_, POLLIN, 0}}};
      ::poll(fds.data(), fds.size(), 2);
      const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - began;
      drive_.advance(std::max(drive_.now(), passed.count() * speed_));
      if (fds[0].revents != 0) return;
      if (fds[1].revents != 0) {
        if (client_ >= 0) ::close(client_);
        client_ = ::accept(listener_, nullptr, nullptr);
        heard.clear();
      } else if (fds[2].revents != 0) {
        hear(heard);
      }
    }
  }

  void hear(Bytes& heard) {
    std::array<std::uint8_t, 512> some{};
    const ssize_t count = ::read(client_, some.data(), some.size());
    if (count <= 0 && tcp_) {
      ::close(client_);
      client_ = -1;
    } else if (count <= 0) {
      ::usleep(2000);  // nobody has the terminal open
    } else {
      heard.insert(heard.end(), some.begin(), some.begin() + count);
    }
    // Unit and request, behind the header of TCP or in front of the check sum of RTU.
    for (;;) {
      const std::size_t head = tcp_ ? 6 : 0, tail = tcp_ ? 0 : 2;
      if (heard.size() < head + 6 + tail) return;
      const bool writes = heard[head + 1] == kWrite;
      if (writes && heard.size() == head + 6) return;
      const std::size_t data = writes ? std::size_t{7} + heard[head + 6] : 6;
      if (heard.size() < head + data + tail) return;
      answer(Bytes(heard.begin(), heard.begin() + static_cast<std::ptrdiff_t>(head + data)), head);
      heard.erase(heard.begin(), heard.begin() + static_cast<std::ptrdiff_t>(head + data + tail));
    }
  }

  void answer(const Bytes& request, std::size_t head) {
    const auto word = [&](std::size_t at) {
      return static_cast<std::uint16_t>(request[head + at] << 8 | request[head + at + 1]);
    };
    const std::uint8_t function = request[head + 1];
    const std::uint16_t address = word(2), count = word(4);
    std::vector<std::uint16_t> words(count);
    sim::Access access = sim::Access::kIllegalAddress;
    Bytes reply{request[head], function};
    if (function == kWrite) {
      for (std::size_t i = 0; i < words.size(); ++i) words[i] = word(7 + 2 * i);
      access = drive_.write(address, words);
      reply.insert(reply.end(), request.begin() + static_cast<std::ptrdiff_t>(head + 2),
                   request.begin() + static_cast<std::ptrdiff_t>(head + 6));
    } else if (function == kRead && count == 1) {
      access = drive_.read(address, words);
      reply.insert(reply.end(),
                   {2, static_cast<std::uint8_t>(words[0] >> 8), static_cast<std::uint8_t>(words[0])});
    }
    if (access != sim::Access::kOk)
      reply = {request[head], static_cast<std::uint8_t>(function | 0x80), static_cast<std::uint8_t>(access)};
    send(request, reply);
  }

  void send(const Bytes& request, Bytes reply) const {
    if (tcp_) {
      const auto size = static_cast<std::uint8_t>(reply.size());
      reply.insert(reply.begin(), {request[0], request[1], 0, 0, 0, size});
    } else {
      unsigned crc = 0xFFFF;
      for (const std::uint8_t byte : reply) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? crc >> 1 ^ 0xA001 : crc >> 1;
      }
      reply.push_back(static_cast<std::uint8_t>(crc));
      reply.push_back(static_cast<std::uint8_t>(crc >> 8));
    }
    static_cast<void>(::write(client_, reply.data(), reply.size()) ==
                      0);  // a peer that has gone is seen above
  }

  sim::DriveController& drive_;
  bool tcp_;
  double speed_;
  int listener_ = -1, client_ = -1, port_ = 0;
};

}  // namespace tiltfeed
