// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>

namespace CLI {
class App;
}

namespace terrace {

/// The program was called wrongly in a way that only the subcommand can see: exit code 2. Everything else
/// that a subcommand throws is exit code 1. what() is printed after the program's name.
class UsageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// One subcommand a file, tools/<name>.cpp. Each adds itself with its options and a callback that does the
// work.
void AddCalibrationCommand(CLI::App& app);
void AddCameraCommand(CLI::App& app);
void AddCheetahCommand(CLI::App& app);
void AddCommandCommand(CLI::App& app);
void AddConvertCommand(CLI::App& app);
void AddDisparityCommand(CLI::App& app);
void AddDoctorCommand(CLI::App& app);
void AddDrawCommand(CLI::App& app);
void AddEvaluateCommand(CLI::App& app);
void AddExplainCommand(CLI::App& app);
void AddExportCommand(CLI::App& app);
void AddInfoCommand(CLI::App& app);
void AddListenCommand(CLI::App& app);
void AddRecordCommand(CLI::App& app);
void AddReportCommand(CLI::App& app);
void AddStatusCommand(CLI::App& app);
void AddServeCommand(CLI::App& app);
void AddSynthesizeCommand(CLI::App& app);
void AddViewCommand(CLI::App& app);

}  // namespace terrace
