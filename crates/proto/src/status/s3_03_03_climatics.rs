//! §3.3.3 «Флаги состояния Climatics»: the same three things for each heated node.

use super::structure;
use crate::flags::flag_class;

structure! {
    /// Climate inside the monitor (§3.3, §3.3.3), 16 bytes.
    ThermoStatus [flags: ClimaticsFlags] {
        /// Temperature of the traverse drive.
        horizontal i16 DeciCelsius;
        /// Temperature of the elevation drive.
        vertical i16 DeciCelsius;
        /// Temperature of the nozzle drive.
        nozzle i16 DeciCelsius;
        /// Temperature of the deployment drive.
        deployer i16 DeciCelsius;
        /// Temperature of the housing.
        housing i16 DeciCelsius;
        /// Humidity in the housing.
        humidity u16 Percent;
    }
}

flag_class! {
    /// §3.3.3 Climatics.
    ClimaticsFlags "3.3.3";
    HORIZONTAL_HEAT = 16 "HorizontalHeat" Info Climatics;
    VERTICAL_HEAT = 17 "VerticalHeat" Info Climatics;
    NOZZLE_HEAT = 18 "NozzleHeat" Info Climatics;
    DEPLOYER_HEAT = 19 "DeployerHeat" Info Climatics;
    BOX_HEAT = 20 "BoxHeat" Info Climatics;
    HORIZONTAL_FAULT = 21 "HorizontalFault" Warning Climatics;
    VERTICAL_FAULT = 22 "VerticalFault" Warning Climatics;
    NOZZLE_FAULT = 23 "NozzleFault" Warning Climatics;
    DEPLOYER_FAULT = 24 "DeployerFault" Warning Climatics;
    BOX_FAULT = 25 "BoxFault" Warning Climatics;
    HORIZONTAL_SENSOR_FAULT = 26 "HorizontalSensorFault" Warning Climatics;
    VERTICAL_SENSOR_FAULT = 27 "VerticalSensorFault" Warning Climatics;
    NOZZLE_SENSOR_FAULT = 28 "NozzleSensorFault" Warning Climatics;
    DEPLOYER_SENSOR_FAULT = 29 "DeployerSensorFault" Warning Climatics;
    BOX_SENSOR_FAULT = 30 "BoxSensorFault" Warning Climatics;
    HUMIDITY_SENSOR_FAULT = 31 "HumiditySensorFault" Warning Climatics;
}
