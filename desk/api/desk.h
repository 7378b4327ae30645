#pragma once
// The desk behind the page: who is signed in, what lies on it, and which request does what (desk/API.md).

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "desk/api/cut_work.h"
#include "desk/api/job_work.h"
#include "desk/api/machine_work.h"
#include "desk/api/metrics_work.h"
#include "desk/api/part_work.h"
#include "desk/api/plan_work.h"
#include "desk/api/reach_work.h"
#include "desk/api/run_api.h"
#include "desk/api/shop_work.h"
#include "desk/api/suggest_work.h"
#include "desk/http/access_check.h"
#include "desk/http/http_message.h"
#include "desk/session/session_table.h"
#include "desk/users/password_check.h"
#include "desk/users/token_table.h"

namespace tiltfeed::desk {

struct DeskOptions {
  std::string self;      ///< this program
  std::string tiltfeed;  ///< what plans
  std::string maker;     ///< tiltfeed-sim: makes the formula parts, cuts programs
  std::string folder;    ///< where its work lies while it runs
  std::string version;   ///< of the program
  std::string service;   ///< socket of the machine's service; empty: none
  std::string machine;   ///< file of its profile, where it is known
  /// On a network: by which names it is addressed, whether by TLS, and the users' file; empty: by token.
  std::vector<std::string> names = {};
  bool https = false;
  std::string users = {};
  std::string tokens = {};  ///< file of programs' tokens; empty: none
  std::string shop = {};    ///< address of the shop's queue; empty: this desk shows no shop
  std::string config = {};  ///< the service's file; empty: not known
};

class Desk {
 public:
  /// `finish`: as HttpServer::finish().
  Desk(const DeskOptions& options, Teller tell, std::function<void(std::uint64_t, const Reply&)> finish);

  /// From then on the server is known by these names only.
  void set_port(std::uint16_t port);
  /// A job (.yaml, .yml) with its part, or a part. Errors: kIo; as JobWork::open().
  Result<void> open(const std::string& path);
  /// An address that signs one browser in, once; where there are users, only the address. Errors: kIo.
  Result<std::string> new_address();

  /// As HttpCalls::admit and HttpCalls::answer.
  std::optional<Reply> admit(const Request& request, BodyRule& rule);
  Reply answer(const Request& request);

  /// What to wait for besides the server.
  std::vector<int> descriptors() const;
  void hear(int descriptor);
  /// Milliseconds after which look() is due; -1: never.
  int patience_ms() const;
  void look();

 private:
  struct Route;
  static const std::vector<Route>& routes();
  const Route* route_of(const Request& request) const;
  std::string cookie_of(const Request& request) const;
  Result<std::optional<ProgramToken>> program_of(const Request& request) const;

  Reply sign_in(const Request& request);
  Reply sign_in_by_password(const Request& request);
  Reply signed_in(const Session& session) const;
  std::string cookie_name() const;
  Reply sign_out(const Request& request);
  Reply session(const Request& request);
  Reply state(const Request& request);
  Reply metrics(const Request& request);
  Reply events(const Request& request);
  Reply put_part(const Request& request);
  Reply set_unit(const Request& request);
  Reply mesh(const Request& request);
  Reply edges(const Request& request);
  Reply part_model(const Request& request);
  Reply part_faces(const Request& request);
  Reply job_text(const Request& request);
  Reply put_job(const Request& request);
  Reply job_changed();
  Reply save_job(const Request& request);
  Reply start_plan(const Request& request);
  Reply cancel_plan(const Request& request);
  Reply program(const Request& request);
  Reply path(const Request& request);
  Reply map(const Request& request);
  Reply report(const Request& request);
  // desk_setup.cpp
  Reply make_sample(const Request& request);
  Reply machines(const Request& request);
  Reply new_job(const Request& request);
  Reply job_file(const Request& request);
  Reply edit_job(const Request& request);
  Reply edit_operations(const Request& request);
  Reply schema(const Request& request);
  Reply start_suggest(const Request& request);
  Reply cancel_suggest(const Request& request);
  Reply ask_reach(const Request& request);
  Reply reach_map(const Request& request);
  Reply ask_fit(const Request& request);
  Reply choose_machine(const Request& request);
  Reply machine_view(const Request& request);
  // desk_cut.cpp
  Reply start_cut(const Request& request);
  Reply cancel_cut(const Request& request);
  Reply cut_view(const Request& request);
  Reply cut_before(const Request& request);
  Reply cut_page(const Request& request);
  Reply cut_report(const Request& request);
  // desk_shop.cpp
  Reply shop(const Request& request);
  Reply release_job(const Request& request);
  Reply withdraw_job(const Request& request);
  Reply raise_shop(const Request& request);
  Reply take_back(const Request& request, const char* command);
  AskedPart asked_part() const;
  PartChoice chosen_part() const;
  std::optional<PlannedProgram> planned() const;
  Result<void> copy_part(const std::string& path, const std::string& unit);

  DeskOptions options_;
  AccessRules rules_;
  std::uint16_t port_ = 0;
  SessionTable sessions_;
  PasswordCheck passwords_;
  std::string nobody_;  ///< a hash for names that are not known: they take as long as others
  std::function<void(std::uint64_t, const Reply&)> finish_;
  Teller tell_;
  PartWork part_;
  JobWork job_;
  PlanWork plan_;
  CutWork cut_;
  SuggestWork suggest_;
  ReachWork reach_;
  MachineWork machine_;
  std::string part_folder_;  ///< of the part that was named at the start; empty: it came otherwise
  RunApi run_;
  ShopWork shop_;
  MetricsWork metrics_;
};

}  // namespace tiltfeed::desk
