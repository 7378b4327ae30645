#pragma once
// The machine beside the page: which request gives it which order, and who may.

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "desk/api/run_scene.h"
#include "desk/http/http_message.h"
#include "desk/service/held_jog.h"
#include "desk/service/run_watch.h"
#include "desk/session/seat.h"

namespace tiltfeed::desk {

/// A program that was planned on this desk: its file, a name for people, and what it was planned with.
struct PlannedProgram {
  std::string file, name;
  std::optional<Placing> placing;
  SceneInput scene;  ///< but for job and program
};

/// Where the service is, and what draws its runs.
struct RunOptions {
  std::string socket;                  ///< of the service; empty: there is none
  std::string machine;                 ///< its profile's file, where it is known
  std::string tiltfeed, self, folder;  ///< as RunScene has them; the folder for a run's files
};

struct RunCalls {
  std::function<void(const std::string&, const std::string&)> tell;  ///< every page that listens
  std::function<void(std::uint64_t ticket, const Reply&)> finish;    ///< a reply that comes later
  std::function<std::optional<PlannedProgram>()> planned;            ///< what submit hands over
  std::function<std::string(std::uint64_t session)> name;            ///< of who has a session, for people
};

/// Properties: no order goes out without the seat, but a hold, which every operator may give; a hold waits
/// for nothing; what a page that is gone held down ends. A program with a token hands jobs over without the
/// seat, and gives no other order: a job that was handed over moves nothing until somebody starts it.
class RunApi {
 public:
  using Time = std::chrono::steady_clock::time_point;

  RunApi(const RunOptions& options, RunCalls calls);

  /// It is one of these requests. `/api/v1/run...` and `/api/v1/seat...`.
  static bool is_route(const std::string& method, const std::string& path);
  /// A program with a token may ask it: what changes nothing, and what hands a program over.
  static bool is_for_programs(const Request& request);
  /// Its body is a file.
  static bool is_file(const Request& request);
  /// Requires: is_route. `session`: of who asks, 0 for a program with a token.
  Reply answer(const Request& request, std::uint64_t session, bool program = false);
  void sign_out(std::uint64_t session);

  std::vector<int> descriptors() const;
  void hear(int descriptor);
  void look(Time now);
  int patience_ms(Time now) const;
  std::string describe_run() const { return watch_.describe(); }
  std::string describe_seat() const;

 private:
  /// `op`: what the service calls it; `keys`: what of the body goes with it.
  struct Route {
    const char* method;
    const char* path;
    Reply (RunApi::*answer)(const Request&, std::uint64_t);
    bool seat = false;
    const char* op = nullptr;
    std::vector<const char*> keys = {};
    bool by_token = false;  ///< a change that a program with a token may ask for
    bool file = false;      ///< its body is a file
  };
  static const std::vector<Route>& routes();
  static const Route* route_of(const std::string& method, const std::string& path);
  /// A machine command that is in work; `ticket` 0: our own.
  struct Order {
    std::uint64_t number = 0, ticket = 0;  // number 0: the service has not said it yet
    bool asking = false;
    Time next;
  };

  Reply run(const Request& request, std::uint64_t session);
  Reply jobs(const Request& request, std::uint64_t session);
  Reply hold(const Request& request, std::uint64_t session);
  Reply plain(const Request& request, std::uint64_t session);
  Reply machine(const Request& request, std::uint64_t session);
  Reply jog(const Request& request, std::uint64_t session);
  Reply jog_beat(const Request& request, std::uint64_t session);
  Reply jog_stop(const Request& request, std::uint64_t session);
  Reply submit(const Request& request, std::uint64_t session);
  Reply program(const Request& request, std::uint64_t session);
  Reply part(const Request& request, std::uint64_t session);
  Reply path(const Request& request, std::uint64_t session);
  Reply mesh(const Request& request, std::uint64_t session);
  Reply seat(const Request& request, std::uint64_t session);
  Reply ask_seat(const Request& request, std::uint64_t session);
  Reply give_seat(const Request& request, std::uint64_t session);
  Reply keep_seat(const Request& request, std::uint64_t session);
  Reply beat_seat(const Request& request, std::uint64_t session);

  static Reply later_reply();
  static Reply reply_of(const Result<std::string>& answer);
  Reply pass_on(const Request& request, const std::string& json, const std::vector<int>& files = {});
  Reply begin_order(std::uint64_t ticket, std::uint64_t session, const std::string& command,
                    const std::string& words);
  void follow(Time now);
  void end_order(const Result<std::string>& end);
  void ask_status();
  void tell_seat();
  std::optional<Placing> placing_of(std::uint64_t job, const std::string& folder);

  std::string machine_, folder_;
  RunCalls calls_;
  ServiceLink link_;
  RunWatch watch_;
  RunScene scene_;
  Seat seat_;
  HeldJog jog_;
  std::optional<Order> order_;
  std::vector<std::function<void()>> after_order_;  // what waits for our own status to end
  std::uint64_t submitted_ = 0;                     // the job that was handed over last
  PlannedProgram submitted_with_;
  std::string told_seat_;
};

}  // namespace tiltfeed::desk
