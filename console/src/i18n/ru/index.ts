import type { Dictionary } from '..';
import shell from './shell';
import parts from './parts';
import login from './login';
import setup from './setup';
import overview from './overview';
import operate from './operate';
import guide from './guide';
import help from './help';
import alarms from './alarms';
import events from './events';
import params from './params';
import programs from './programs';
import commissioning from './commissioning';
import diagnosis from './diagnosis';
import inspector from './inspector';
import replay from './replay';
import training from './training';
import admin from './admin';
import zones from './zones';

// The type checker requires every key of the English texts here.
const ru: Dictionary = {
  ...shell,
  ...parts,
  ...login,
  ...setup,
  ...overview,
  ...operate,
  ...guide,
  ...help,
  ...alarms,
  ...events,
  ...params,
  ...programs,
  ...commissioning,
  ...diagnosis,
  ...inspector,
  ...replay,
  ...training,
  ...admin,
  ...zones,
};

export default ru;
