#include <iostream>
#include <memory>
#include <optional>

#include "apps/commands/command.h"
#include "apps/console/exit_status.h"
#include "apps/console/output.h"
#include "apps/reports/html/html_report.h"
#include "relief/io/mesh_io.h"
#include "scan/io/files/atomic_file.h"

namespace relief {

namespace {

struct ReportCommand {
  CommonOptions common;
  std::filesystem::path folder;
  std::filesystem::path model;   // Empty: model.ply in the folder.
  std::filesystem::path output;  // Empty: report.html in the folder.
  HtmlReportOptions html;
};

// A folder may lack the model: aligning and refining write reports, too.
Result<std::optional<TriangleMesh>> model_of(const ReportCommand& command) {
  const std::filesystem::path path =
      command.model.empty() ? command.folder / "model.ply" : command.model;
  if (command.model.empty() && !std::filesystem::exists(path)) return {std::nullopt};
  auto mesh = read_mesh(path);
  if (!mesh) return mesh.error();
  return {std::move(*mesh)};
}

int write_report_page(const ReportCommand& command) {
  HtmlReportFiles files;
  files.folder = command.folder;
  files.page = command.output.empty() ? command.folder / "report.html" : command.output;
  files.report = report_path(command.common, command.folder / "report.json");
  const auto mesh = model_of(command);
  if (!mesh) return fail(mesh.error());
  if (const auto ready = prepare_folder_of(files.page); !ready) return fail(ready.error());
  HtmlReportOptions options = command.html;
  const auto written = run_in(context_of(command.common, "report"), [&] {
    return write_html_report(files, *mesh ? &**mesh : nullptr, options);
  });
  if (!written) return fail(written.error());
  if (command.common.json) std::cout << read_file(files.report).value() << std::flush;
  return kDone;
}

}  // namespace

void add_report(CLI::App& app, Action& action) {
  auto command = std::make_shared<ReportCommand>();
  auto* sub = app.add_subcommand("report", "Write report.html again from what a folder has");
  sub->add_option("folder", command->folder,
                  "Folder with report.json, and scan.json and model.ply if there are any")
      ->required()
      ->check(CLI::ExistingDirectory);
  sub->add_option("--model", command->model, "Mesh file instead of model.ply in the folder");
  sub->add_option("-o,--output", command->output, "The page, instead of report.html in the folder");
  add_html_report_options(*sub, command->html);
  add_common_options(*sub, command->common);
  sub->callback([command, &action] { action = [command] { return write_report_page(*command); }; });
}

}  // namespace relief
