// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include "core/standard_streams.h"
#include "tools/commands.h"

namespace {

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kWrongUse = 2;

int Run(int argc, char** argv) {
  CLI::App app("The toolbox of Terrace, the stereo terrain mapper.", "terrace");
  app.set_version_flag("--version", "terrace " TERRACE_VERSION);
  app.require_subcommand(1);
  terrace::AddCalibrationCommand(app);
  terrace::AddCameraCommand(app);
  terrace::AddCheetahCommand(app);
  terrace::AddCommandCommand(app);
  terrace::AddConvertCommand(app);
  terrace::AddDisparityCommand(app);
  terrace::AddDoctorCommand(app);
  terrace::AddDrawCommand(app);
  terrace::AddEvaluateCommand(app);
  terrace::AddExplainCommand(app);
  terrace::AddExportCommand(app);
  terrace::AddInfoCommand(app);
  terrace::AddListenCommand(app);
  terrace::AddRecordCommand(app);
  terrace::AddReportCommand(app);
  terrace::AddStatusCommand(app);
  terrace::AddServeCommand(app);
  terrace::AddSynthesizeCommand(app);
  terrace::AddViewCommand(app);

  try {
    app.parse(argc, argv);  // runs the subcommand's callback
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kWrongUse;  // --help and --version come this way too
  } catch (const terrace::UsageError& error) {
    std::fprintf(stderr, "terrace: %s\n", error.what());
    return kWrongUse;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "terrace: %s\n", error.what());
    return kFailed;
  }
  return kDone;
}

}  // namespace

int main(int argc, char** argv) {
  terrace::OccupyStandardStreams();
  const int code = Run(argc, argv);
  if (terrace::StandardOutputIsWritten() || code != kDone) return code;
  std::fprintf(stderr, "terrace: standard output cannot be written\n");
  return kFailed;
}
