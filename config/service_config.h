#pragma once
// The file of `tiltfeed serve --config F`: one machine, its wire, where its jobs lie. Every key:
// config/service.yaml.

#include <string>

#include "config/machine_profile.h"
#include "config/queue_key.h"

namespace tiltfeed::config {

/// What of the past a service keeps; 0: all of it.
struct Retention {
  int days = 0;          ///< an ended job goes with its files so long after its end
  int mib = 0;           ///< the jobs that ended first go while the files of all jobs are more
  int history_days = 0;  ///< a run of a job that is removed is forgotten so long after its end
  bool keeps_all() const { return days == 0 && mib == 0 && history_days == 0; }
};

struct ServiceConfig {
  std::string path;
  MachineProfile machine;
  std::string link;           ///< LINK text; the profile's default where the file names none
  std::string spool, socket;  ///< folder; file
  std::string watch;          ///< folder whose programs (*.nc) are submitted; empty: none
  Retention retention;
  QueueChoice queue;  ///< the shop's, beside the spool's own
};

/// Relative paths start at the file's folder. Errors: kInput as file:line:column, kIo.
Result<ServiceConfig> load_service_config(const std::string& path);
Result<ServiceConfig> parse_service_config(const std::string& text, const std::string& path);

}  // namespace tiltfeed::config
