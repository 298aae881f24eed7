// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Results of `study sensors` as a table, sentences and a page.

#include <string>
#include <vector>

#include "mesh/machine_mesh.h"
#include "tools/study/chosen_sensors.h"

namespace thermotwin::tools {

std::vector<std::vector<std::string>> sensor_table(const std::vector<mesh::SensorSpec>& sensors,
                                                   const ChosenSensors& choice);
/// What machines measured virtually say, one sentence each; empty: none was measured.
std::vector<std::string> confirmation_sentences(const ChosenSensors& choice);
/// What is left along each load program: no sensors, those of the case, the chosen ones.
std::vector<std::vector<std::string>> confirmation_table(const ConfirmedSensors& confirmed);
/// Of the criterion's two parts, where a second mesh tells the one of the mesh.
std::string mesh_error_sentence(const ChosenSensors& choice);

std::string sensors_page(const StudySensorsOptions& options, const mesh::MachineMesh& mesh, const ChosenSensors& choice,
                         const std::vector<mesh::SensorSpec>& sensors);

}  // namespace thermotwin::tools
