/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_FMI2_NAMES_H
#define THERMOTWIN_FMI2_NAMES_H
/* Names of the functions where FMI2_FUNCTION_PREFIX is defined, so that several FMUs fit into one program. */
#ifdef FMI2_FUNCTION_PREFIX
#define FMI2_JOIN(prefix, name) prefix##name
#define FMI2_FULL(prefix, name) FMI2_JOIN(prefix, name)
#define fmi2CancelStep FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2CancelStep)
#define fmi2DeSerializeFMUstate FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2DeSerializeFMUstate)
#define fmi2DoStep FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2DoStep)
#define fmi2EnterInitializationMode FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2EnterInitializationMode)
#define fmi2ExitInitializationMode FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2ExitInitializationMode)
#define fmi2FreeFMUstate FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2FreeFMUstate)
#define fmi2FreeInstance FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2FreeInstance)
#define fmi2GetBoolean FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetBoolean)
#define fmi2GetBooleanStatus FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetBooleanStatus)
#define fmi2GetDirectionalDerivative FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetDirectionalDerivative)
#define fmi2GetFMUstate FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetFMUstate)
#define fmi2GetInteger FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetInteger)
#define fmi2GetIntegerStatus FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetIntegerStatus)
#define fmi2GetReal FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetReal)
#define fmi2GetRealOutputDerivatives FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetRealOutputDerivatives)
#define fmi2GetRealStatus FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetRealStatus)
#define fmi2GetStatus FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetStatus)
#define fmi2GetString FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetString)
#define fmi2GetStringStatus FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetStringStatus)
#define fmi2GetTypesPlatform FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetTypesPlatform)
#define fmi2GetVersion FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2GetVersion)
#define fmi2Instantiate FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2Instantiate)
#define fmi2Reset FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2Reset)
#define fmi2SerializeFMUstate FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2SerializeFMUstate)
#define fmi2SerializedFMUstateSize FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2SerializedFMUstateSize)
#define fmi2SetBoolean FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2SetBoolean)
#define fmi2SetDebugLogging FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2SetDebugLogging)
#define fmi2SetFMUstate FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2SetFMUstate)
#define fmi2SetInteger FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2SetInteger)
#define fmi2SetReal FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2SetReal)
#define fmi2SetRealInputDerivatives FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2SetRealInputDerivatives)
#define fmi2SetString FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2SetString)
#define fmi2SetupExperiment FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2SetupExperiment)
#define fmi2Terminate FMI2_FULL(FMI2_FUNCTION_PREFIX, fmi2Terminate)
#endif

#endif
