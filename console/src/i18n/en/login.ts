export default {
  'login.title': 'Log in',
  'login.user': 'User',
  'login.password': 'Password',
  'login.show': 'Show',
  'login.hide': 'Hide',
  'login.enter': 'Log in',
  'login.checking': 'Checking…',
  'login.wait': 'Next try in {s} s',
  'login.user_first': 'Enter your user name',
  'login.password_first': 'Enter your password',
  'login.failed': 'The user name or the password is wrong. Each wrong try makes the next one wait longer.',
  'login.too_often': 'There were several wrong tries from here. Wait, then try again.',
  'login.unreachable': 'The hub does not answer. Look at the network, and try again.',
  'login.capitals': 'Caps Lock is on',
  'login.ended':
    'Your session has ended. STOP and LOCKOUT still work; for everything else log in again: the page that you were on comes back.',
  'login.link_used': 'This link has been used: there is an administrator already. Log in.',
};
