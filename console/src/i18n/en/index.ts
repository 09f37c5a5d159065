// Each page has its own file; keys start with the page's name.

import admin from './admin';
import alarms from './alarms';
import commissioning from './commissioning';
import diagnosis from './diagnosis';
import events from './events';
import guide from './guide';
import help from './help';
import inspector from './inspector';
import login from './login';
import operate from './operate';
import overview from './overview';
import params from './params';
import parts from './parts';
import programs from './programs';
import replay from './replay';
import setup from './setup';
import shell from './shell';
import training from './training';
import updates from './updates';
import zones from './zones';

export default {
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
  ...updates,
  ...admin,
  ...zones,
};
